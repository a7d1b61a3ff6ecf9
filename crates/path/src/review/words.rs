//! The words of a program line for comparison by a person: letters and numbers, without block numbers, comments and number formats.
//!
//! This reads any language approximately: unknown text becomes a word without a number.

/// A word of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineWord<'a> {
    /// Its address: `X`, `POS[X]`, `R1`.
    pub address: &'a str,
    /// The text after the address.
    pub value: &'a str,
    /// The number, if the value is one.
    pub number: Option<f64>,
}

/// The number of a block: `N120`, `:10`.
#[must_use]
pub fn block_number(line: &str) -> Option<&str> {
    let text = line.trim_start().trim_start_matches('/').trim_start();
    let begins = text.starts_with(['N', 'n', ':']);
    let digits = text.get(1..).unwrap_or_default().bytes().take_while(u8::is_ascii_digit).count();
    text.get(..1 + digits).filter(|_| begins && digits > 0)
}

/// The words of a line. Comments are left out: `;` to the end, and parentheses that are not an argument.
#[must_use]
pub fn words(line: &str) -> Vec<LineWord<'_>> {
    let mut out = Vec::new();
    let mut rest = line.trim_start().trim_start_matches('/').trim_start();
    if let Some(number) = block_number(rest) {
        rest = &rest[number.len()..];
    }
    loop {
        rest = rest.trim_start();
        if rest.is_empty() || rest.starts_with(';') {
            return out;
        }
        if let Some(inside) = rest.strip_prefix('(') {
            rest = inside.split_once(')').map_or("", |(_, behind)| behind);
            continue;
        }
        let address = address_length(rest);
        if address == 0 {
            // A character that does not begin a word.
            rest = rest.get(rest.chars().next().map_or(1, char::len_utf8)..).unwrap_or_default();
            continue;
        }
        let (name, behind) = rest.split_at(address);
        let after_equals = behind.trim_start().strip_prefix('=').map(str::trim_start);
        let value_at = after_equals.unwrap_or(behind);
        let length = value_length(value_at);
        let value = &value_at[..length];
        out.push(LineWord { address: name, value, number: number(value) });
        rest = &value_at[length..];
    }
}

/// Length of an address, bytes: one letter, or a longer name with an equals sign or an argument after it.
fn address_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$' | b'#');
    if !bytes.first().is_some_and(|byte| byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$' | b'#')) {
        return 0;
    }
    let mut name = bytes.iter().take_while(|byte| is_name(byte)).count();
    if bytes.get(name) == Some(&b'[') {
        name += text[name..].find(']').map_or(text.len() - name, |end| end + 1);
    }
    let has_equals = text[name..].trim_start().starts_with('=');
    let letters = bytes.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    if has_equals || letters > 1 || bytes[0] == b'#' || name > 0 && bytes[0] == b'$' { name } else { 1 }
}

/// Length of a value, bytes: a number, or an expression up to the next blank outside brackets.
fn value_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let digits = bytes[sign..].iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'.').count();
    let next = bytes.get(sign + digits);
    if digits > 0 && !next.is_some_and(|byte| matches!(byte, b'*' | b'/' | b'+' | b'-' | b'(')) {
        return sign + digits;
    }
    let mut depth = 0_i32;
    for (place, byte) in bytes.iter().enumerate() {
        match byte {
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth -= 1,
            b';' | b' ' | b'\t' if depth <= 0 => return place,
            _ => {}
        }
    }
    text.len()
}

/// Parses a decimal number.
fn number(text: &str) -> Option<f64> {
    let digits = text.bytes().any(|byte| byte.is_ascii_digit());
    text.parse::<f64>().ok().filter(|_| digits)
}

/// The number of decimals of a number as written.
#[must_use]
pub fn decimals(value: &str) -> usize {
    value.split_once('.').map_or(0, |(_, behind)| behind.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(line: &str) -> Vec<(&str, &str)> {
        words(line).into_iter().map(|word| (word.address, word.value)).collect()
    }

    #[test]
    fn words_are_found_in_all_languages() {
        assert_eq!(
            shown("N10 G1 X-1.5Y2.F030 (A HOLE) M8"),
            [("G", "1"), ("X", "-1.5"), ("Y", "2."), ("F", "030"), ("M", "8")]
        );
        assert_eq!(shown("/N10 X=R2*COS(R11) Y=IC(3 + 1) ; to X5"), [("X", "R2*COS(R11)"), ("Y", "IC(3 + 1)")]);
        assert_eq!(shown("POS[X]=10 X1=2 AP=45"), [("POS[X]", "10"), ("X1", "2"), ("AP", "45")]);
        assert_eq!(shown("X[#24+#18*COS[#32]] Y3"), [("X", "[#24+#18*COS[#32]]"), ("Y", "3")]);
        assert_eq!(shown("#101=180. (LENGTH)"), [("#101", "180.")]);
        assert_eq!(shown("%"), []);
        assert_eq!(shown("; only a remark"), []);
        assert_eq!(shown("é X1"), [("X", "1")]);
        assert_eq!(words("X3.100 F30.0").iter().map(|word| word.number).collect::<Vec<_>>(), [Some(3.1), Some(30.0)]);
        for (line, number) in
            [("N120 X1", Some("N120")), (":7 G1", Some(":7")), ("/N5", Some("N5")), ("NX", None), ("", None)]
        {
            assert_eq!(block_number(line), number, "{line}");
        }
        assert_eq!(["1.250", "3", "-2."].map(decimals), [3, 0, 0]);
    }
}
