//! Equality of texts.

/// Relative tolerance of equal numbers, absolute below one.
const SAME_NUMBER: f64 = 1e-6;

/// `true` if two texts are equal except for blanks, capitals and number formats.
pub(super) fn is_same_text(one: &str, other: &str) -> bool {
    let mut sides = [Pieces(one), Pieces(other)];
    loop {
        let [one, other] = &mut sides;
        match (one.next(), other.next()) {
            (None, None) => return true,
            (Some(Piece::Number(one)), Some(Piece::Number(other))) => {
                if (one - other).abs() > (SAME_NUMBER * one.abs()).max(SAME_NUMBER) {
                    return false;
                }
            }
            (Some(Piece::Sign(one)), Some(Piece::Sign(other))) if one == other => {}
            _ => return false,
        }
    }
}

/// A number, or any other character except blanks.
enum Piece {
    Number(f64),
    Sign(char),
}

struct Pieces<'a>(&'a str);

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        self.0 = self.0.trim_start();
        let digits = self.0.bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
        if digits > 0
            && let Ok(number) = self.0[..digits].parse()
        {
            self.0 = &self.0[digits..];
            return Some(Piece::Number(number));
        }
        let sign = self.0.chars().next()?;
        self.0 = &self.0[sign.len_utf8()..];
        Some(Piece::Sign(sign.to_ascii_uppercase()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_the_same_however_their_numbers_are_written() {
        for (one, other, is_same) in [
            ("ADIS=0.50", "ADIS=0.5", true),
            ("G64 P0.01", "g64p0.010", true),
            ("G64 P0.01", "G64 P0.02", false),
            ("CYCLE832(0.01,1)", "CYCLE832( 0.01 , 1 )", true),
            ("A", "AB", false),
        ] {
            assert_eq!(is_same_text(one, other), is_same, "{one} {other}");
        }
    }
}
