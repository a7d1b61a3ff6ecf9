#!/usr/bin/env python3
"""generate.py SEED [FOLDER COUNT [correctable]]: a random RS274/NGC program from a seed on standard output, or COUNT of them into FOLDER.

For differential testing with compare.py. The programs are meant to be valid, but need not be: what the interpreter does not accept is not
compared. Each piece begins where the program knows its position, and leads back to such a place. With `correctable` they keep away from
what a correction refuses: G28.1 and G30.1, and X without Y behind a tool change, where only the machine knows how far a rotated X leads.
"""

import math
import os
import random
import sys


class Generator:
    def __init__(self, seed, correctable=False):
        self.random = random.Random(seed)
        self.correctable = correctable
        self.lines = []
        self.depth = 0
        self.labels = 100
        self.inch = False
        self.position = [0.0, 0.0, 0.0]
        self.subs = []
        self.block_numbers = self.random.random() < 0.3
        self.lower = self.random.random() < 0.3
        self.tight = self.random.random() < 0.3

    # ── text ──

    def put(self, text):
        if self.lower and "(" not in text:
            text = text.lower()
        if self.tight and "o<" not in text.lower() and "(" not in text:
            text = text.replace(" ", "")
        elif self.random.random() < 0.1 and "(" not in text:
            text = text.replace(" ", "  ")
        indent = "" if text.startswith("/") else "  " * self.depth
        if self.block_numbers and not text.lower().startswith(("o", "/")) and self.random.random() < 0.8:
            text = f"N{10 * (len(self.lines) + 1)} {text}"
        if self.random.random() < 0.05:
            text += self.random.choice([" (note)", " ; note", " (a) (b)"])
        self.lines.append(indent + text)

    def number(self, value):
        text = f"{value:.4f}".rstrip("0").rstrip(".")
        if text in ("-0", ""):
            text = "0"
        choice = self.random.random()
        if choice < 0.1 and "." not in text:
            return text + "."
        if choice < 0.15 and value > 0:
            return "+" + text
        if choice < 0.2 and text.startswith("0."):
            return text[1:]
        return text

    def value(self, value):
        """The value as a number or as an expression that has it."""
        value = round(value, 4)
        r = self.random
        if r.random() > 0.15:
            return self.number(value)
        a = round(r.uniform(-9, 9), 3)
        form = r.randrange(11)
        if form > 7:
            # The tree is worth anything; the rest makes it the value.
            text, worth = self.tree(r.randint(1, 4))
            return f"[{self.plain(value - worth)} + [{text}]]"
        if form == 0:
            return f"[{self.number(a)} + {self.plain(value - a)}]"
        if form == 1:
            return f"[{self.plain(value / 2)} * 2]"
        if form == 2:
            return f"[{self.plain(value * 4)} / 4]"
        if form == 3:
            return f"[{self.plain(value)} + SIN[0] * 3]"
        if form == 4:
            return f"[{self.plain(value)} * COS[360]]"
        if form == 5:
            return f"[{self.plain(value - 8)} + 2 ** 3]"
        if form == 6:
            return f"[{self.plain(value - 2)} + FIX[2.9] * [3 GT 2]]"
        name = r.choice(["#31", "#<val>", "#<_glob>"])
        self.put(f"{name} = {self.plain(value)}")
        return name

    def tree(self, depth):
        """An expression whose brackets are left to the precedence of the interpreter, and what it is worth, rounded as the text of its
        remainder is. Both sides compute it: the worth only keeps positions small."""
        text, worth, _ = self.subtree(depth)
        return text, round(worth, 8)

    def subtree(self, depth):
        """Text, worth and rank of the operator that binds least (5: none)."""
        r = self.random
        if depth == 0:
            number = round(r.uniform(0.1, 9), r.choice([0, 1, 2])) or 1.0
            return self.plain(number), number, 5
        kind = r.random()
        if kind < 0.25:
            name, of = r.choice([("SIN", lambda x: math.sin(math.radians(x))), ("COS", lambda x: math.cos(math.radians(x))), ("ABS", abs),
                                 ("SQRT", lambda x: math.sqrt(abs(x))), ("FIX", math.floor), ("FUP", math.ceil), ("EXP", lambda x: math.exp(min(x, 5)))])
            text, worth, _ = self.subtree(depth - 1)
            if name == "SQRT":
                return f"SQRT[ABS[{text}]]", of(worth), 5
            if name == "EXP":
                return f"EXP[SIN[{text}]]", math.exp(math.sin(math.radians(worth))), 5
            if name in ("FIX", "FUP") and abs(worth - round(worth)) < 1e-6:
                return f"[{text}]", worth, 5
            return f"{name}[{text}]", of(worth), 5
        if kind < 0.32:
            (one, a, _), (other, b, _) = self.subtree(depth - 1), self.subtree(depth - 1)
            return f"ATAN[{one}]/[{other}]", math.degrees(math.atan2(a, b)), 5
        sign, rank, of = r.choice([("+", 3, lambda a, b: a + b), ("-", 3, lambda a, b: a - b), ("*", 4, lambda a, b: a * b),
                                   ("/", 4, lambda a, b: a / b), (" MOD ", 4, lambda a, b: a % abs(b)), ("**", 5, lambda a, b: abs(a) ** b),
                                   (" LT ", 2, lambda a, b: float(a < b)), (" GE ", 2, lambda a, b: float(a >= b)),
                                   (" AND ", 1, lambda a, b: float(a != 0 and b != 0)), (" OR ", 1, lambda a, b: float(a != 0 or b != 0)),
                                   (" XOR ", 1, lambda a, b: float((a != 0) != (b != 0)))])
        (one, a, left), (other, b, right) = self.subtree(depth - 1), self.subtree(depth - 1)
        risky = sign in ("/", " MOD ", "**") and (abs(b) < 0.1 or (sign == "**" and (not 0.1 < a < 20 or abs(b) > 3)))
        near = sign.strip() in ("LT", "GE") and abs(a - b) < 1e-6 or sign == " MOD " and abs(a / (b or 1) - round(a / (b or 1))) < 1e-6
        if risky or near:
            sign, rank, of = "+", 3, lambda a, b: a + b
        worth = of(a, b)
        if abs(worth) > 1e4:
            sign, rank, worth = "-", 3, a - b
        one = one if left >= rank and r.random() < 0.9 else f"[{one}]"
        # Of operators of one rank the left one comes first.
        other = other if right > rank and r.random() < 0.9 else f"[{other}]"
        return f"{one}{sign}{other}", worth, rank

    @staticmethod
    def plain(value):
        text = f"{value:.8f}".rstrip("0").rstrip(".")
        return "0" if text == "-0" else text

    def coordinate(self, low=-60.0, high=60.0):
        return round(self.random.uniform(low, high), self.random.choice([0, 1, 2, 3]))

    def label(self):
        self.labels += 1
        return f"o{self.labels}" if self.random.random() < 0.7 else f"o<label_{self.labels}>"

    def feed(self):
        return f" F{self.number(self.random.choice([100, 250.5, 800, 1200]))}" if self.random.random() < 0.3 else ""

    # ── pieces ──

    def here(self):
        """An absolute rapid to a place that is known from then on."""
        self.position = [self.coordinate(), self.coordinate(), self.coordinate(0, 30)]
        x, y, z = (self.number(value) for value in self.position)
        self.put(f"G90 G0 X{x} Y{y} Z{z}")

    def lines_piece(self):
        r = self.random
        incremental = r.random() < 0.35
        if incremental:
            self.put("G91")
        motion = r.choice(["G0", "G1"])
        for index in range(r.randint(1, 5)):
            words = [motion] if index == 0 or r.random() < 0.2 else []
            axes = r.sample(range(3), r.randint(1, 3))
            for axis in axes:
                to = self.coordinate(-20, 20) if incremental else self.coordinate()
                words.append("XYZ"[axis] + self.value(to))
                self.position[axis] = round(self.position[axis] + to, 9) if incremental else to
            r.shuffle(words)
            self.put(" ".join(words) + (self.feed() if motion == "G1" else ""))
        if incremental:
            self.put("G90")

    def arcs_piece(self):
        r = self.random
        plane = r.choice([17, 17, 18, 19])
        first, second, third = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}[plane]
        self.put(f"G{plane}")
        absolute_centers = r.random() < 0.2
        self.put("G90.1" if absolute_centers else "G91.1")
        self.here()
        for _ in range(r.randint(1, 4)):
            radius = round(r.uniform(1, 25), 2)
            at = r.uniform(-math.pi, math.pi)
            sweep = r.uniform(0.2, 6.0)
            code = r.choice([2, 3])
            start = list(self.position)
            center = [start[first] - radius * math.cos(at), start[second] - radius * math.sin(at)]
            to = at + (sweep if code == 3 else -sweep)
            end = list(start)
            end[first] = round(center[0] + radius * math.cos(to), 4)
            end[second] = round(center[1] + radius * math.sin(to), 4)
            helix = r.random() < 0.3
            if helix:
                end[third] = self.coordinate(-10, 30)
            words = [f"G{code}"]
            form = r.random()
            full = form < 0.15
            if full:
                end = list(start)
                if helix:
                    end[third] = self.coordinate(-10, 30)
            else:
                words += ["XYZ"[axis] + self.number(end[axis]) for axis in (first, second)]
            if helix:
                words.append("XYZ"[third] + self.number(end[third]))
            if form > 0.7 and not full and 0.4 < sweep < 5.6 and abs(sweep - math.pi) > 0.3:
                words.append("R" + self.number(radius if sweep < math.pi else -radius))
            else:
                for axis, middle in zip((first, second), center):
                    offset = middle if absolute_centers else middle - start[axis]
                    words.append("IJK"[axis] + self.plain(offset))
            if r.random() < 0.2:
                words.append(f"P{r.randint(1, 3)}")
            self.position = end
            self.put(" ".join(words) + self.feed())
        self.put("G17 G91.1")

    def cycles_piece(self):
        r = self.random
        self.here()
        code = r.choice(["G81", "G82", "G83", "G73", "G85", "G86", "G89"])
        plane = r.choice([17, 17, 17, 18, 19])
        first, second, third = {17: "XYZ", 18: "ZXY", 19: "YZX"}[plane]
        if plane != 17:
            self.put(f"G{plane}")
            self.put(f"G0 {third}25")
        self.put("G94 F300 M3")
        incremental = r.random() < 0.3
        clearance = round(r.uniform(1, 8), 1)
        words = [r.choice(["G98", "G99", ""]), code]
        if incremental:
            words = ["G91"] + words
            words += [f"{first}{self.value(self.coordinate(-10, 10))}", f"{second}{self.value(self.coordinate(-10, 10))}"]
            words += [f"{third}{self.number(-clearance - 5)}", f"R{self.number(r.choice([-2.0, 0.0, 1.5]))}"]
        else:
            words += [f"{first}{self.value(self.coordinate())}", f"{second}{self.value(self.coordinate())}"]
            words += [f"{third}{self.value(-abs(self.coordinate(1, 15)))}", f"R{self.number(clearance)}"]
        if code in ("G82", "G86", "G89"):
            words.append(f"P{self.number(round(r.uniform(0, 1), 2))}")
        if code in ("G83", "G73"):
            words.append(f"Q{self.number(round(r.uniform(0.8, 6), 2))}")
        if r.random() < 0.25:
            words.append(f"L{r.randint(1, 3)}")
        self.put(" ".join(word for word in words if word) + self.feed())
        for _ in range(r.randint(0, 4)):
            more = [r.choice([first, second]) + self.value(self.coordinate(-15, 15))]
            if r.random() < 0.15:
                more.append(r.choice(["G98", "G99"]))
            if r.random() < 0.15 and not incremental:
                more.append(f"R{self.number(round(clearance + r.uniform(0, 2), 1))}")
            if r.random() < 0.15 and not incremental:
                more.append(f"{third}{self.number(-r.randint(1, 12))}")
            self.put(" ".join(more))
        self.put(r.choice(["G80", "G80 G90", "G0 G90 X0 Y0" if plane == 17 else "G80"]))
        self.put("G80 G90 G17")
        self.here()

    def offsets_piece(self):
        r = self.random
        for _ in range(r.randint(1, 3)):
            form = r.randrange(9)
            if form == 0:
                turn = f" R{self.number(r.choice([0, 15, -30, 90]))}" if r.random() < 0.4 else ""
                self.put(f"G10 L2 P{r.randint(0, 9)} X{self.coordinate()} Y{self.coordinate()}{turn}")
            elif form == 1:
                self.put(r.choice(["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]))
            elif form == 2:
                self.put(f"G92 X{self.coordinate()} Y{self.coordinate()}" + (" Z5" if r.random() < 0.3 else ""))
            elif form == 3:
                self.put(r.choice(["G92.1", "G92.2", "G92.3"]))
            elif form == 4:
                self.put(f"G52 X{self.coordinate(-10, 10)} Y{self.coordinate(-10, 10)}")
            elif form == 5:
                self.put("G52 X0 Y0 Z0")
            elif form == 6:
                self.put(f"G10 L20 P{r.randint(0, 9)} X{self.coordinate()} Z{self.coordinate(0, 10)}")
            elif form == 7:
                self.put(f"G53 G{r.choice([0, 1])} X{self.coordinate()} Z{self.coordinate(0, 40)}")
            else:
                code = r.choice(["28", "30"])
                if r.random() < 0.5 and not self.correctable:
                    self.put(f"G{code}.1")
                self.put(f"G{code}" + (f" Z{self.coordinate(10, 40)}" if r.random() < 0.6 else ""))
            if r.random() < 0.5:
                self.put(f"G1 X{self.coordinate()} Y{self.coordinate()}")
        self.here()

    def tool_piece(self):
        r = self.random
        tool = r.randint(1, 40)
        # The interpreter as a library does not take note of M61: there the length goes by number.
        set_by_number = r.random() < 0.2
        self.put(f"M61 Q{tool}" if set_by_number else f"T{tool} M6")
        self.put(f"G43 H{tool}" if set_by_number else r.choice([f"G43 H{tool}", "G43", "G49", f"G43 H{r.randint(1, 40)}", f"G43.1 Z{self.coordinate(0, 50)}", f"G43.2 H{r.randint(1, 9)}"]))
        if r.random() < 0.4:
            self.put(f"G1 X{self.coordinate()}" + (f" Y{self.coordinate()}" if self.correctable else ""))
        self.here()

    def compensation_piece(self):
        r = self.random
        tool = r.randint(1, 40)
        radius = (1 + 0.5 * (tool % 10)) / 2
        side = r.choice(["G41", "G42"])
        count = r.randint(3, 7)
        sense = r.choice([1, -1])
        x0, y0 = self.coordinate(-30, 30), self.coordinate(-30, 30)
        size = r.uniform(6 * radius + 4, 60)
        corners = []
        for index in range(count):
            angle = sense * 2 * math.pi * index / count + r.uniform(-0.3, 0.3)
            reach = size * r.uniform(0.5, 1.0)
            corners.append((round(x0 + reach * math.cos(angle), 3), round(y0 + reach * math.sin(angle), 3)))
        if self.inch:
            self.put("G49 G21")
            self.inch = False
        self.here()
        start = corners[0]
        self.put(f"G0 X{self.number(round(start[0] + size, 2))} Y{self.number(round(start[1] + r.uniform(-5, 5), 2))}")
        if r.random() < 0.5:
            self.put(f"{side}.1 D{self.number(2 * radius)}")
        else:
            self.put(f"{side} D{tool}")
        self.put(f"G1 X{self.number(start[0])} Y{self.number(start[1])} F500")
        at = start
        for corner in corners[1:] + corners[:1]:
            chord = math.dist(at, corner)
            if r.random() < 0.3 and chord > 2:
                self.put(f"G{r.choice([2, 3])} X{self.number(corner[0])} Y{self.number(corner[1])} R{self.number(round(chord * r.uniform(0.6, 2), 3))}")
            else:
                self.put(f"G1 X{self.number(corner[0])} Y{self.number(corner[1])}" + (" Z-1" if r.random() < 0.1 else ""))
            if r.random() < 0.1:
                self.put(f"G1 Z{self.coordinate(-5, 5)}")
            at = corner
        self.put("G40" if r.random() < 0.7 else f"G40 G1 X{self.coordinate()} Y{self.coordinate()}")
        self.here()

    def polar_piece(self):
        r = self.random
        for _ in range(r.randint(1, 3)):
            self.put(f"{r.choice(['G0', 'G1'])} @{self.value(abs(self.coordinate(5, 50)))} ^{self.value(self.coordinate(-180, 180))}")
        if r.random() < 0.5:
            self.put(f"G1 ^{self.number(self.coordinate(-180, 180))}")
        if r.random() < 0.5:
            self.put(f"G1 @{self.number(abs(self.coordinate(5, 50)))}")
        if r.random() < 0.4:
            self.put(f"G91 G1 @{self.number(abs(self.coordinate(1, 5)))} ^{self.number(self.coordinate(-90, 90))}")
        self.here()

    def spline_piece(self):
        r = self.random
        self.here()
        form = r.randrange(3)
        near = lambda: self.number(self.coordinate(-15, 15))
        if form == 0:
            self.put(f"G5 I{near()} J{near()} P{near()} Q{near()} X{self.coordinate()} Y{self.coordinate()}")
            for _ in range(r.randint(0, 2)):
                self.put(f"G5 P{near()} Q{near()} X{self.coordinate()} Y{self.coordinate()}")
        elif form == 1:
            self.put(f"G5.1 X{self.coordinate()} Y{self.coordinate()} I{self.coordinate(2, 20)} J{near()}")
        else:
            order = r.choice([3, 3, 4])
            self.put(f"G5.2 P{r.choice([1, 2])} L{order}")
            for _ in range(order + r.randint(1, 3)):
                self.put(f"X{self.number(self.coordinate())} Y{self.number(self.coordinate())} P{self.number(r.choice([1, 0.5, 2]))}")
            self.put("G5.3")
        self.put("G1 X1 Y1")
        self.here()

    def rotary_piece(self):
        r = self.random
        axis = r.choice("ABC")
        self.put(f"G0 {axis}{self.coordinate(-180, 180)}")
        self.put(f"G1 X{self.coordinate()} {axis}{self.coordinate(-180, 180)} F400")
        if r.random() < 0.5:
            self.put("G93")
            self.put(f"G1 X{self.coordinate()} Y{self.coordinate()} {axis}{self.coordinate(-90, 90)} F2.5")
            self.put(f"G1 Z{self.coordinate(0, 20)} F3")
            self.put("G94 F300")
        if r.random() < 0.5:
            self.put(f"G91 G1 {axis}{self.coordinate(-40, 40)} Y{self.coordinate(-5, 5)} F300")
            self.put("G90")
        self.here()

    def units_piece(self):
        self.inch = not self.inch
        # Nor does it convert a length in force.
        self.put("G49")
        self.put("G20" if self.inch else "G21")
        self.here()

    def misc_piece(self):
        r = self.random
        self.put(
            r.choice(
                [
                    f"G4 P{self.number(round(r.uniform(0, 2), 2))}",
                    "M3 S1200",
                    "M5",
                    "M8",
                    "M9",
                    "G61",
                    "G64",
                    "G64 P0.02",
                    "G64 P0.02 Q0.01",
                    "G61.1",
                    "/ G1 X3",
                    "/G0 Y-2",
                    "(a note)",
                    "; a note",
                    "",
                    "(MSG, hello)",
                    "(debug, value #5420)",
                    "M1",
                    "M0",
                    "S800 M4",
                    "G97 S900",
                    "F150",
                    "G94 F700",
                ]
            )
        )
        self.here()

    def parameters_piece(self):
        """Parameters that the interpreter keeps by itself: positions, offsets, modes; computed numbers of parameters, values that come back."""
        r = self.random
        self.here()
        for _ in range(r.randint(1, 3)):
            form = r.randrange(8)
            if form == 0:
                self.put(f"G1 X[#5420 + {self.plain(self.coordinate(-9, 9))}] Y[#5421 / 2]")
            elif form == 1:
                self.put(f"G1 X[#<_x> - 1] Z[#<_z> + 2]")
            elif form == 2:
                self.put(f"G0 X[#[5221 + 20 * FIX[#5220 - 1]] / 10] Y[#5211 / 10]")
            elif form == 3:
                # Assignments of a block take effect when all of it is read.
                self.put(f"#31 = {self.plain(self.coordinate())}")
                self.put(f"#31 = {self.plain(self.coordinate())} #32 = [#31 / 2] X#31")
                self.put("X#31 Y#32")
            elif form == 4:
                self.put("#40 = 41")
                self.put(f"##40 = {self.plain(self.coordinate())}")
                self.put("G1 X#41 Y#[#40] Z##40")
            elif form == 5:
                self.put("G1 X[#<_metric> * 3] Y[#<_plane> / 100] Z[#<_absolute> * 4 + #<_incremental>]")
            elif form == 6 and self.subs:
                name, arguments = r.choice(self.subs)
                self.put(f"{name} call " + " ".join(f"[{self.tree(2)[0]}]" for _ in range(arguments)))
                self.put("G90 G1 X[#<_value_returned> * 5]")
            else:
                self.put(f"#<there> = [EXISTS[#<there>] + {r.randint(1, 5)}]" if r.random() < 0.5 else "#<there> = 2")
                self.put("G1 X#<there>")
        self.here()

    def flow_piece(self):
        r = self.random
        if self.depth > 2:
            return self.lines_piece()
        label = self.label()
        form = r.randrange(5)
        counter = f"#{200 + self.depth}" if r.random() < 0.5 else f"#<count_{self.depth}>"
        if form == 0:
            self.put(f"{label} repeat [{r.randint(0, 3)}]")
            self.inside(r.randint(1, 2))
            self.put(f"{label} endrepeat")
        elif form == 1:
            self.put(f"{counter} = 0")
            self.put(f"{label} while [{counter} LT {r.randint(1, 3)}]")
            self.put(f"{counter} = [{counter} + 1]")
            self.inside(1)
            self.leaves(label, counter)
            self.inside(1)
            self.put(f"{label} endwhile")
        elif form == 2:
            self.put(f"{counter} = {r.randint(0, 3)}")
            self.put(f"{label} do")
            self.put(f"{counter} = [{counter} - 1]")
            self.inside(1)
            self.leaves(label, counter)
            self.put(f"{label} while [{counter} GT 0]")
        elif form == 3:
            self.put(f"{counter} = {r.randint(0, 3)}")
            self.put(f"{label} if [{counter} {r.choice(['EQ', 'NE', 'LT', 'LE', 'GT', 'GE'])} 1]")
            self.inside(1)
            if r.random() < 0.5:
                self.put(f"{label} elseif [{counter} EQ 3 OR {counter} EQ 2]")
                self.inside(1)
            if r.random() < 0.5:
                self.put(f"{label} else")
                self.inside(1)
            self.put(f"{label} endif")
        elif self.subs:
            name, arguments = r.choice(self.subs)
            values = " ".join(f"[{self.plain(self.coordinate(-20, 20))}]" for _ in range(arguments))
            self.put(f"{name} call {values}".rstrip())
        self.here()

    def leaves(self, label, counter):
        """Often `break` or `continue` or both, executed or not: what the interpreter passes of them has consequences for later loops too."""
        r = self.random
        if r.random() < 0.4:
            for leave in r.sample(["break", "continue"], r.randint(1, 2)):
                inner = self.label()
                self.put(f"{inner} if [{counter} EQ {r.randint(1, 2)}]")
                self.put(f"{label} {leave}")
                self.put(f"{inner} endif")

    def inside(self, count):
        self.depth += 1
        for _ in range(count):
            self.piece(simple=True)
        self.depth -= 1

    def sub(self):
        name = f"o<part_{len(self.subs)}>" if self.random.random() < 0.6 else f"o{900 + len(self.subs)}"
        arguments = self.random.randint(0, 3)
        self.put(f"{name} sub")
        self.depth += 1
        self.put("G90 G0 X0 Y0")
        if arguments:
            self.put(f"G1 X[#1 + {self.number(self.coordinate(-5, 5))}] Y#{arguments} F300")
            self.put("#1 = [#1 * 2]")
            self.put(f"#<local> = #{arguments}")
            self.put("X[#<local> - 1] Y[#1 / 4]")
        self.here()
        self.inside(1)
        if self.random.random() < 0.3:
            check = self.label()
            self.put(f"{check} if [#1 GT 0]")
            self.put(f"{name} return [#1 + 1]")
            self.put(f"{check} endif")
            self.put("G1 Y4 F250")
        self.depth -= 1
        self.put(f"{name} endsub" + (" [#1]" if self.random.random() < 0.3 else ""))
        self.subs.append((name, arguments))

    def piece(self, simple=False):
        pieces = [self.lines_piece] * 6 + [self.arcs_piece] * 4 + [self.cycles_piece] * 2 + [self.misc_piece] * 2 + [self.polar_piece]
        if self.depth < 3:
            pieces += [self.flow_piece] * (1 if simple else 4)
        if not simple:
            pieces += [self.offsets_piece] * 3 + [self.tool_piece] * 2 + [self.compensation_piece] * 2
            pieces += [self.spline_piece, self.rotary_piece, self.units_piece] + [self.parameters_piece] * 2
        self.random.choice(pieces)()

    def program(self):
        r = self.random
        wrapped = r.random() < 0.3
        if wrapped:
            self.lines.append("%")
        for _ in range(r.randint(0, 2)):
            self.sub()
        self.put("G21 G90 G17 G94 G40 G80 G54")
        self.put("T1 M6 G43")
        self.put("F500 S1000 M3")
        self.here()
        for _ in range(r.randint(3, 12)):
            self.piece()
        self.put(r.choice(["M2", "M30"]))
        if wrapped:
            self.lines.append("%")
        return "\n".join(self.lines) + "\n"


def main():
    seed = int(sys.argv[1])
    if len(sys.argv) < 4:
        sys.stdout.write(Generator(seed).program())
        return
    folder, count = sys.argv[2], int(sys.argv[3])
    os.makedirs(folder, exist_ok=True)
    for index in range(seed, seed + count):
        with open(os.path.join(folder, f"random_{index}.ngc"), "w", encoding="ascii") as out:
            out.write(Generator(index, "correctable" in sys.argv[4:]).program())


main()
