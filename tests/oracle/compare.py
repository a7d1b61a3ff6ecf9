#!/usr/bin/env python3
"""compare.py [OPTIONS] FILE-OR-FOLDER…: holds `ncfix` against LinuxCNC's interpreter, program by program. See README.md beside it.

Modes (--mode):
  snc        the flat stream of `ncfix snc` against the moves of the interpreter
  roundtrip  `ncfix IN -o OUT` with a model without errors: the interpreter must make the same of OUT as of IN
  wear       `ncfix IN -o OUT --compensation wear`: with wear alone in the tool table OUT goes where IN goes with the whole radius
  model      the same with a constant and a linear error: what changes must be what the model asks for
"""

import argparse
import collections
import concurrent.futures
import fnmatch
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ENDINGS = (".ngc", ".nc", ".tap", ".gcode", ".eia", ".cnc", ".txt")
POSITION_TOLERANCE = 1e-4
# The holes of a cycle share their heights within the tolerance of the correction, 1 µm.
CYCLE_TOLERANCE = 1e-3
"""mm and degrees."""
CURVE_TOLERANCE = 0.02
"""mm: both sides cut splines into pieces of their own choice."""
WRITTEN_CURVE_TOLERANCE = 0.005
"""mm: an output is within the tolerance of 1 um and half an increment of the curve, and its arcs are sampled here."""
BULGE = 1.5
"""How much more than estimated (`bulges`) a spline may be off the interpreter's pieces: those of generate.py are up to 1.1 times as far."""
LEAST_RATES = (0.1, 2.54)
"""mm/min in G93: a tenth of a millimeter, a tenth of an inch."""
WEARS = (0.05, -0.03)
"""mm."""
WEAR_TOLERANCE = 2.5e-3
"""mm: the rounding of the output at both ends of elements."""
NO_END = "ended with no percent sign"
PATIENCE = 20.0
"""Seconds without a sign of life."""

# ── the two sides ─────────────────────────────────────────────────────────────────────────────

Step = collections.namedtuple("Step", "kind line place feed center plane turns tool text tilt", defaults=(0.0,))
"""One thing done. kind: G0 G1 ARC DWELL. turns: signed, as the interpreter counts. place of a dwell: its seconds."""


def tools():
    """The tool table both sides get: lengths and radii that tell tools apart and are small enough for most programs."""
    return [{"number": n, "length_mm": 20.0 + n, "diameter_mm": 1 + 0.5 * (n % 10)} for n in range(1, 100)]


def run(command, seconds, **more):
    try:
        return subprocess.run(command, capture_output=True, timeout=seconds, **more)
    except subprocess.TimeoutExpired:
        return None


def ask_judge(path, setup, *more):
    """The interpreter's answer, or an object with an error. `more`: switches of judge.py."""
    command = ["/usr/bin/python3", os.path.join(HERE, "judge.py"), path, "--tools", setup.tool_file]
    done = run([*command, *more], setup.seconds)
    if done is None:
        return {"elements": [], "error": {"line": 0, "text": "does not come to an end"}}
    try:
        answer = json.loads(done.stdout)
    except ValueError:
        return {"elements": [], "error": {"line": 0, "text": f"breaks down ({done.returncode}): {done.stderr[-200:]!r}"}}
    if answer["error"] and NO_END in answer["error"]["text"] and "--append-end" not in more:
        return ask_judge(path, setup, *more, "--append-end")
    return answer


def judge_steps(answer):
    steps = []
    for element in answer["elements"]:
        kind, line = element[:2]
        if kind == "DWELL":
            steps.append(Step("DWELL", line, [element[2]], 0.0, None, 0, 0, None, str(element)))
        if kind not in ("G0", "G1", "ARC", "PROBE", "TAP"):
            continue
        place, tool = element[2], element[3]
        feed = element[4] if len(element) > 4 else 0.0
        center, plane, turns, tilt = element[5:9] if kind == "ARC" else (None, 0, 0, 0.0)
        text = f"{kind} {show(place)}" + (f" F{feed:.6g}" if feed else "")
        text += f" center {show(center)} G{plane} turns {turns}" if center else ""
        kinds = {"PROBE": "G1"}
        if kind == "TAP":
            place = place[:3] + (steps[-1].place[3:] if steps else [0.0] * 6)
            back = next((step for step in reversed(steps) if step.kind != "DWELL"), None)
            steps.append(Step("G1", line, place, feed, None, 0, 0, tool, text))
            steps.append(Step("G1", line, back.place if back else [0.0] * 9, feed, None, 0, 0, tool, text + " and back"))
            continue
        steps.append(Step(kinds.get(kind, kind), line, place, feed, center, plane, turns, tool, text, tilt))
    return steps


WORD = re.compile(r"([A-Z])(-?[0-9.]+(?:e-?\d+)?)")


def ncfix_steps(text):
    """Steps of an SNC text."""
    steps = []
    place = [0.0] * 6
    for line in text.splitlines():
        body, _, origin = line.partition(" ;@")
        if not body.startswith("G"):
            continue
        words = WORD.findall(body)
        code = int(words[0][1])
        values = {letter: float(value) for letter, value in words[1:]}
        at = int(re.match(r"\d*", origin).group() or 0)
        if code == 4:
            seconds = values.get("S", values.get("R", 0.0))
            steps.append(Step("DWELL", at, [seconds], 0.0, None, 0, 0, None, line))
            continue
        start = place
        place = [values.get(letter, place[slot]) for slot, letter in enumerate("XYZABC")]
        feed = values.get("F", 0.0)
        if code < 2:
            steps.append(Step(f"G{code}", at, place, feed, None, 0, 0, None, line))
            continue
        center = [start[slot] + values.get(letter, 0.0) for slot, letter in enumerate("IJK")]
        turns = (int(values.get("L", 0)) + 1) * (-1 if code == 2 else 1)
        steps.append(Step("ARC", at, place, feed, center, int(values["P"]), turns, None, line))
    return steps


# ── the comparison ────────────────────────────────────────────────────────────────────────────


def show(values):
    return " ".join(f"{value:.6f}".rstrip("0").rstrip(".") for value in values or [])


def near(one, other, tolerance=POSITION_TOLERANCE):
    slots = max(len(one), len(other))
    one = list(one) + [0.0] * (slots - len(one))
    other = list(other) + [0.0] * (slots - len(other))
    return all(abs(a - b) <= tolerance + 1e-9 * abs(a) for a, b in zip(one, other))


def axis_command(step):
    return [value + shift for value, shift in zip(step.place, step.tool)]


def turned(point, angle):
    """A point about Z."""
    cos, sin = math.cos(angle), math.sin(angle)
    return [cos * point[0] - sin * point[1], sin * point[0] + cos * point[1], *point[2:]]


def sampled(step, start, sagitta=math.inf):
    """Points of an arc from `start`, without its first one; the lines between them are off it by no more than `sagitta`."""
    if step.tilt and step.plane != 17:
        # The arc lies in a plane that the rotation of the zero offset tilts.
        place, center = turned(step.place, -step.tilt), turned(step.center, -step.tilt)
        flat = sampled(step._replace(place=place, center=center, tilt=0.0), turned(start, -step.tilt), sagitta)
        return [turned(point, step.tilt) for point in flat]
    first, second = {17: (0, 1), 18: (2, 0), 19: (1, 2)}[step.plane]
    center = step.center
    at, to = (math.atan2(p[second] - center[second], p[first] - center[first]) for p in (start, step.place))
    angle = (to - at) % (2 * math.pi)
    if step.turns < 0:
        angle -= 2 * math.pi if angle > 1e-9 else 0
        angle = angle if abs(angle) > 1e-9 else -2 * math.pi
        angle -= 2 * math.pi * (-step.turns - 1)
    else:
        angle = angle if abs(angle) > 1e-9 else 2 * math.pi
        angle += 2 * math.pi * (step.turns - 1)
    radius = math.hypot(start[first] - center[first], start[second] - center[second])
    end_radius = math.hypot(step.place[first] - center[first], step.place[second] - center[second])
    count = max(8, int(abs(angle) * max(60, math.sqrt(max(radius, end_radius) / (8 * sagitta)))))
    points = []
    for index in range(1, count + 1):
        share = index / count
        point = [a + (b - a) * share for a, b in zip(start, step.place)]
        r = radius + (end_radius - radius) * share
        point[first] = center[first] + r * math.cos(at + angle * share)
        point[second] = center[second] + r * math.sin(at + angle * share)
        points.append(point)
    return points


def distance(point, start, end):
    """Of a point from a straight line, in X Y Z."""
    along = [b - a for a, b in zip(start[:3], end[:3])]
    to = [b - a for a, b in zip(start[:3], point[:3])]
    square = sum(value * value for value in along)
    share = max(0.0, min(1.0, sum(a * b for a, b in zip(along, to)) / square)) if square else 0.0
    return math.dist(point[:3], [a + b * share for a, b in zip(start[:3], along)])


def stretch_of(steps, index, start):
    """The points of what the block at `index` does, and the index behind it."""
    points, line = [start], steps[index].line
    while index < len(steps) and steps[index].line == line and steps[index].kind in ("G1", "ARC"):
        step = steps[index]
        points += sampled(step, points[-1]) if step.kind == "ARC" else [step.place]
        index += 1
    return points, index


def bulges(line):
    """About how far a curve is off each of the pieces of `line`, which cut it in equal steps of its parameter: an eighth of the second
    difference of their corners, the larger one of both ends. A share of their length would not do: where the curve turns sharply, the
    pieces are the shortest and the furthest off it."""
    corners = zip(line, line[1:], line[2:])
    turns = [math.dist([a + c for a, c in zip(one[:3], other[:3])], [2 * b for b in middle[:3]]) for one, middle, other in corners]
    return [max(ends) / 8 for ends in zip([0.0, *turns], [*turns, 0.0])]


def off_line(points, line, allowances):
    """The first of the points that is further off a line of pieces than it may be off its piece, or None. Goes along the line, so that loops
    do not hide a detour. Where `line` turns sharply its pieces may be many and short: it is searched over a few pieces, and over a few times
    the way from the last point."""
    segment, last = 0, points[0]
    window = 3 + 4 * len(line) // len(points)
    for point in points:
        reach, travelled = 4 * math.dist(point[:3], last[:3]), 0.0
        best = None
        for k in range(segment, len(line) - 1):
            if k >= segment + window and travelled > reach:
                break
            found = (distance(point, line[k], line[k + 1]), k)
            best = found if best is None else min(best, found)
            travelled += math.dist(line[k][:3], line[k + 1][:3])
        if best is None or best[0] > allowances[best[1]]:
            return point
        segment, last = best[1], point
    return None


def polylines_agree(theirs, mine, tolerance=POSITION_TOLERANCE, curve=CURVE_TOLERANCE):
    """The corners of the interpreter's pieces lie on the curve, which is off the pieces between them. `curve` is how far `mine` may be off it."""
    return (
        off_line(theirs, mine, [curve] * len(mine)) is None
        and off_line(mine, theirs, [CURVE_TOLERANCE + BULGE * bulge for bulge in bulges(theirs)]) is None
        and near(theirs[-1], mine[-1], tolerance)
    )


SPINDLE_DRIVEN = re.compile(rb"g *(33|74|76|84)", re.I)
SPLINE = re.compile(rb"g0*[56](\.[1-3])?(?![0-9.])", re.I)


def differ(judge, ours, source_lines):
    """None, or the first difference as text."""
    i = j = 0
    last, command, their_tip = [0.0] * 6, [0.0] * 9, [0.0] * 9
    inverse_time = any(b"G93" in line.upper() for line in source_lines)
    spindle_driven = any(SPINDLE_DRIVEN.search(line) for line in source_lines)
    lengths = []
    while True:
        # What moves nothing is not compared: one side orders it, the other leaves it out.
        while i < len(judge) and judge[i].kind in ("G0", "G1") and near(axis_command(judge[i]), command, 2e-5):
            their_tip = judge[i].place
            lengths.append(judge[i].tool)
            i += 1
        if i < len(judge) and judge[i].tool:
            lengths.append(judge[i].tool)
        tips = [last] + [[value - shift for value, shift in zip(command, length)] for length in lengths]
        while j < len(ours) and ours[j].kind in ("G0", "G1") and any(near(ours[j].place, tip, 2e-5) for tip in tips):
            # Another length in force, and the tip goes where it was: a move.
            if i < len(judge) and one_differs(judge[i], ours[j], their_tip, inverse_time) is None:
                break
            last = ours[j].place
            j += 1
        if i == len(judge) and j == len(ours):
            return None
        if i == len(judge) or j == len(ours):
            rest = ours[j].text if i == len(judge) else f"line {judge[i].line}: {judge[i].text}"
            who = "ncfix goes on" if i == len(judge) else "ncfix ends before"
            return f"{who}: {rest}"
        theirs, mine = judge[i], ours[j]
        fault = one_differs(theirs, mine, their_tip, inverse_time)
        if fault == "feed" and spindle_driven and mine.feed == 0:
            # The spindle drives threads and rigid taps, whatever F is.
            fault = None
        if fault is None:
            lengths = []
            if theirs.kind != "DWELL":
                last, command, their_tip = mine.place, axis_command(theirs), theirs.place
            i, j = i + 1, j + 1
            continue
        # A spline, or an arc in a plane that the rotation tilts: the path counts, not the pieces.
        # A rotation by right angles leaves an arc in a plane of the axes, which ncfix names.
        tilted = theirs.kind == "ARC" and (mine.kind == "G1" or mine.kind == "ARC" and theirs.tilt != 0 and theirs.plane != mine.plane)
        if tilted or SPLINE.search(source_lines[theirs.line - 1] if theirs.line <= len(source_lines) else b""):
            if theirs.kind in ("G1", "ARC") and mine.kind in ("G1", "ARC"):
                one, next_i = ([their_tip] + sampled(theirs, their_tip), i + 1) if tilted else stretch_of(judge, i, their_tip)
                other, next_j = stretch_of(ours, j, last)
                if polylines_agree(one, other):
                    command, their_tip = axis_command(judge[next_i - 1]), judge[next_i - 1].place
                    last = ours[next_j - 1].place
                    i, j = next_i, next_j
                    continue
        # Steps of no size that one side counts and the other does not.
        if theirs.kind in ("G0", "G1") and near(axis_command(theirs), command):
            i += 1
            continue
        if mine.kind in ("G0", "G1") and near(mine.place, last):
            j += 1
            continue
        return f"{fault}: line {theirs.line}: {theirs.text} | ncfix: {mine.text}"


def one_differs(theirs, mine, start, inverse_time):
    if theirs.kind != mine.kind:
        return f"kind {theirs.kind}, not {mine.kind}"
    if not near(theirs.place, mine.place):
        return "duration" if theirs.kind == "DWELL" else "end point"
    if theirs.kind == "ARC":
        if theirs.plane != mine.plane:
            return "plane"
        if theirs.turns != mine.turns:
            return "turns"
        flat = {17: (0, 1), 18: (2, 0), 19: (1, 2)}[theirs.plane]
        if not all(abs(theirs.center[slot] - mine.center[slot]) <= POSITION_TOLERANCE for slot in flat):
            return "center"
    if theirs.kind in ("G1", "ARC") and abs(theirs.feed - mine.feed) > 1e-3 + 1e-5 * theirs.feed:
        length = math.dist(theirs.place[:3], start[:3])
        if theirs.kind == "ARC":
            points = [start] + sampled(theirs, start)
            length = sum(math.dist(a[:3], b[:3]) for a, b in zip(points, points[1:]))
        rate = length * mine.feed
        # The interpreter's rate of a short move is not below a tenth of the program's unit (inverse_time_rate_straight and …_arc).
        is_least = any(abs(theirs.feed - least) < 1e-6 and rate < least for least in LEAST_RATES)
        if not (inverse_time and (is_least or abs(rate - theirs.feed) <= 0.002 * theirs.feed + 1e-3)):
            return "feed"
    return None


# ── what a corrected program makes of the moves ───────────────────────────────────────────────

MODEL = {"X": (0.0123, 2e-5), "Y": (-0.0071, 0.0), "Z": (0.0052, 0.0)}
"""Positioning errors EXX, EYY, EZZ of the mode `model`: mm, and mm per mm."""

MODEL_TEXT = '\n[[motion]]\ncomponent = "E{0}{0}"\nkind = "polynomial"\ncoefficients = [{1}, {2}]\n'


def command_for(place, model):
    """The axis command that brings the axes to `place` in spite of the errors."""
    out = list(place)
    for slot, axis in enumerate("XYZ"):
        constant, slope = model.get(axis, (0.0, 0.0))
        out[slot] = (place[slot] - constant) / (1 + slope)
    return out


def place_at(command, model):
    """Where the axes really are at a command."""
    out = list(command)
    for slot, axis in enumerate("XYZ"):
        constant, slope = model.get(axis, (0.0, 0.0))
        out[slot] = command[slot] + constant + slope * command[slot]
    return out


def same_place(wanted, real, model, nominal, tolerance=None):
    """`wanted` and `real` are commands. An axis that the program has not named yet stays where it is: at its uncorrected start."""
    tolerance = tolerance or POSITION_TOLERANCE + (1e-4 if model else 0.0)
    for slot, (one, other) in enumerate(zip(wanted, real)):
        if abs(one - other) > tolerance and not (slot < 3 and abs(nominal[slot]) < 1e-9 and abs(other) < 1e-9):
            return False
    return True


def is_left(real, end, wanted, nominal, actual):
    """Whether a rapid move that is no approach to a cut ends well: each axis corrected, or as programmed, or where it stood if the program does not move it."""
    tolerance = POSITION_TOLERANCE + 1e-4
    return all(
        abs(real[k] - wanted[k]) <= tolerance
        or abs(real[k] - end[k]) <= tolerance
        or (abs(end[k] - nominal[k]) < 1e-9 and abs(real[k] - actual[k]) <= tolerance)
        for k in range(min(len(real), len(end)))
    )


def swept(points, plane, center):
    first, second = {17: (0, 1), 18: (2, 0), 19: (1, 2)}[plane]
    angles = [math.atan2(p[second] - center[second], p[first] - center[first]) for p in points]
    return abs(sum((b - a + math.pi) % (2 * math.pi) - math.pi for a, b in zip(angles, angles[1:])))


def unequal_radii(step, start):
    """How much the radii to the end and to the start (a command) of an arc differ: the way between them is the control's business."""
    if step.kind != "ARC":
        return 0.0
    flat = {17: (0, 1), 18: (2, 0), 19: (1, 2)}[step.plane]
    center = [value + shift for value, shift in zip(step.center, step.tool)]
    one, other = (math.hypot(*(p[slot] - center[slot] for slot in flat)) for p in (start, axis_command(step)))
    return abs(one - other)


def length_of(points):
    return sum(math.dist(a[:3], b[:3]) for a, b in zip(points, points[1:]))


def beside(points, reals, tolerance):
    """How far the first of `reals` that is further beside the line of `points` than `tolerance` is, or 0."""
    window = 4 + 4 * len(points) // len(reals)
    for number, real in enumerate(reals):
        # Both go the same way: look near the same share of it first.
        about = number * len(points) // len(reals)
        around = points[max(0, about - window) : about + window + 1]
        off = min((distance(real, a, b) for a, b in zip(around, around[1:])), default=math.inf)
        if off > tolerance:
            off = min(distance(real, a, b) for a, b in zip(points, points[1:]))
        if off > tolerance:
            return off
    return 0.0


def moving(steps):
    """Without what moves nothing."""
    out, at = [], [0.0] * 9
    for step in steps:
        if step.kind in ("G0", "G1") and near(axis_command(step), at, 2e-5):
            continue
        if step.kind != "DWELL":
            at = axis_command(step)
        out.append(step)
    return out


def stands_at(step, nominal, model):
    """Whether a straight move leads to where the program already is."""
    if step.kind not in ("G0", "G1"):
        return False
    wanted, real = command_for(nominal, model), axis_command(step)
    return near(real, wanted, 2.5e-4) or same_place(wanted, real, model, nominal)


CHANGE = re.compile(rb"[TM]\s*\d|G\s*(43|49|10|92|52|5[3-9]|17|18|19|28|30)", re.I)


def leads_to_a_cut(steps, following, source_lines):
    """Whether the next move is one with feed, with the same tool, zero and plane."""
    step = next((step for step in steps[following:] if step.kind != "DWELL"), None)
    if step is None or step.kind == "G0":
        return False
    first, last = sorted((steps[following - 1].line, step.line))
    return not any(CHANGE.search(line) for line in source_lines[first:last])


def differ_corrected(before, after, model, source_lines, inverse_time):
    """None, or the first difference between the moves of a program and those of its corrected text."""
    before, after = moving(before), moving(after)
    count_of_line = collections.Counter(step.line for step in after)
    i = j = 0
    nominal, actual = [0.0] * 9, [0.0] * 9
    unstated = set()
    while i < len(before) and j < len(after):
        theirs, mine = before[i], after[j]
        straight = theirs.kind in ("G0", "G1")
        end = axis_command(theirs) if straight else nominal
        # Even a very small move of the program is one.
        meets = straight and mine.kind == theirs.kind and same_place(command_for(end, model), axis_command(mine), model, end, 1e-4)
        if straight and not meets and (near(end, nominal) or same_place(command_for(end, model), actual, model, end, 1e-4)):
            # Less than the decimals of the output show: its next move is for one of the next of the program.
            nominal = end
            i += 1
            continue
        if not meets and stands_at(mine, nominal, model):
            # Named but not moved: now the axis stands where the model wants it.
            actual = axis_command(mine)
            j += 1
            continue
        if theirs.kind == "DWELL" or mine.kind == "DWELL":
            if theirs.kind != mine.kind or not near(theirs.place, mine.place):
                return f"dwell: line {theirs.line}: {theirs.text} | output line {mine.line}: {mine.text}"
            i, j = i + 1, j + 1
            continue
        spline = theirs.line <= len(source_lines) and SPLINE.search(source_lines[theirs.line - 1])
        points = [nominal[:3]]
        next_i = i
        while True:
            step = before[next_i]
            shifts = step.tool[:3]
            if step.kind == "ARC":
                tip = [value - shift for value, shift in zip(points[-1], shifts)] + [0.0] * 6
                points += [[v + t for v, t in zip(point, shifts)] for point in sampled(step, tip, 3e-4)]
            else:
                points.append(axis_command(step)[:3])
            next_i += 1
            if not spline or next_i == len(before) or before[next_i].line != theirs.line or before[next_i].kind != theirs.kind:
                break
        last = before[next_i - 1]
        end = axis_command(last)
        wanted = command_for(end, model)
        done, next_j, path = False, j, [actual]
        sweep = swept(points, theirs.plane, [v + t for v, t in zip(theirs.center, theirs.tool)]) if theirs.kind == "ARC" else 0.0
        length, travel, seconds = length_of(points), 0.0, 0.0
        while next_j < len(after) and not done:
            step = after[next_j]
            if step.kind == "DWELL" or (step.kind == "G0") != (theirs.kind == "G0"):
                break
            if not spline and theirs.kind == "G1" and step.kind != "G1":
                break
            count = len(path)
            if step.kind == "ARC":
                tip = [value - shift for value, shift in zip(path[-1], step.tool)]
                path += [[v + t for v, t in zip(point, step.tool)] for point in sampled(step, tip)]
            else:
                path.append(axis_command(step))
            if theirs.kind != "G0" and not feed_agrees(theirs, step, inverse_time):
                return f"feed: line {theirs.line}: {theirs.text} | output line {step.line}: {step.text}"
            next_j += 1
            travel += length_of(path[count - 1 :])
            seconds += 60 * length_of(path[count - 1 :]) / step.feed if step.feed else 0.0
            # A closed spline is where it ends from its start.
            tolerance = CYCLE_TOLERANCE if model and count_of_line[step.line] > 2 else None
            done = same_place(wanted, path[-1], model, end, tolerance) and not (spline and travel < 0.98 * length - CURVE_TOLERANCE)
            if theirs.kind == "G0" and model and not done and not leads_to_a_cut(before, next_i, source_lines):
                done = is_left(path[-1], end, wanted, nominal, actual)
                # Behind a tool change the program has not stated where these axes are; they stay there until it moves them.
                follows = next((step for step in before[next_i:] if step.kind != "DWELL"), None)
                if done and follows and follows.kind != "G0":
                    unstated = {k for k, one in enumerate(path[-1]) if not near([one], [wanted[k]], POSITION_TOLERANCE + 1e-4)}
            elif unstated and model and not done:
                unstated = {k for k in unstated if abs(end[k] - nominal[k]) < 1e-9}
                done = same_place([end[k] if k in unstated else one for k, one in enumerate(wanted)], path[-1], model, end)
            if theirs.kind == "ARC" and done:
                center = [v + t for v, t in zip(theirs.center, theirs.tool)]
                done = swept([place_at(point, model) for point in path], theirs.plane, center) > sweep - 0.05
        if not done:
            return f"end point {show(wanted)} is not reached: line {theirs.line}: {theirs.text} | output line {mine.line}: {mine.text}"
        if inverse_time and theirs.feed and length > 1 and near(end[3:], nominal[3:]):
            # In G93 each piece has its own feed: together they must last as long.
            wanted_seconds = 60 * length / theirs.feed
            if abs(seconds - wanted_seconds) > 0.02 * wanted_seconds + 0.001:
                return f"{seconds:.6g} s instead of {wanted_seconds:.6g} s: line {theirs.line}: {theirs.text} | output line {mine.line}: {mine.text}"
        if theirs.kind != "G0" and not unstated and not (any(abs(v) < 1e-9 for v in actual[:3]) and model):
            reals = [place_at(point, model)[:3] for point in path]
            off = beside(points, reals, 0.003 + unequal_radii(theirs, points[0])) if not spline else not polylines_agree(points, reals, 5e-4, WRITTEN_CURVE_TOLERANCE)
            if off:
                return f"{'spline' if spline else f'{off:.6f} mm'} off the path: line {theirs.line}: {theirs.text} | output line {mine.line}: {mine.text}"
        unstated = {k for k in unstated if theirs.kind == "G0" or abs(end[k] - nominal[k]) < 1e-9}
        nominal, actual = end, path[-1]
        i, j = next_i, next_j
    while j < len(after) and stands_at(after[j], nominal, model):
        j += 1
    if i < len(before) or j < len(after):
        rest = before[i] if i < len(before) else after[j]
        return f"{'the output ends before' if i < len(before) else 'the output goes on'}: line {rest.line}: {rest.text}"
    return None


def feed_agrees(theirs, mine, inverse_time):
    return inverse_time or abs(theirs.feed - mine.feed) <= 1e-3 + 1e-4 * theirs.feed


# ── running a program ─────────────────────────────────────────────────────────────────────────

Verdict = collections.namedtuple("Verdict", "path outcome text")
"""outcome: agrees, differs, refused, broken, no moves, not accepted."""


def first_finding(text):
    found = re.search(r"^error\[\w+\].*?$(\s*-->.*?$)?", text, re.M | re.S) or re.search(r"^error.*$", text, re.M)
    return " ".join(found.group().split()) if found else text[-200:]


def refused(done):
    if done is None:
        return "broken", "ncfix does not come to an end"
    errors = done.stderr.decode("utf8", "replace")
    if done.returncode in (0, 1, 2, 3, 4):
        return "refused", first_finding(errors)
    return "broken", f"status {done.returncode}: {errors[-300:]}"


def moves(steps):
    return sum(step.kind != "DWELL" for step in steps)


def check_snc(path, setup):
    # `ncfix snc` shows feed moves without F (and warns); a correction of them is refused, as the control refuses to run them.
    answer = ask_judge(path, setup, "--any-feed")
    if answer["error"]:
        return Verdict(path, "not accepted", f"line {answer['error']['line']}: {answer['error']['text']}")
    judge = judge_steps(answer)
    done = run([setup.ncfix, "snc", "--dialect", "rs274", "--machine", setup.machine, path], setup.seconds)
    if done is None or done.returncode != 0:
        outcome, text = refused(done)
        return Verdict(path, outcome if moves(judge) or outcome == "broken" else "no moves", text)
    ours = ncfix_steps(done.stdout.decode("utf8", "replace"))
    with open(path, "rb") as file:
        lines = file.read().splitlines()
    text = differ(judge, ours, lines)
    if not text and not moves(judge):
        return Verdict(path, "no moves", "")
    return Verdict(path, "differs" if text else "agrees", text or "")


def check_corrected(path, setup, model):
    answer = ask_judge(path, setup)
    if answer["error"]:
        return Verdict(path, "not accepted", answer["error"]["text"])
    before = judge_steps(answer)
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, os.path.basename(path))
        command = [setup.ncfix, path, "-o", out, "--dialect", "rs274", "--machine", setup.machine, "--max-correction", "1mm"]
        done = run(command, setup.seconds)
        if done is not None and b"error[E0304]" in done.stderr:
            # It depends on where the axes are at its start: where the interpreter has them.
            done = run([*command, "--start", "X0,Y0,Z0"], setup.seconds)
        if done is None or done.returncode != 0 or not os.path.exists(out):
            outcome, text = refused(done)
            return Verdict(path, outcome if moves(before) or outcome == "broken" else "no moves", text)
        again = ask_judge(out, setup)
        with open(out, "rb") as file:
            output = file.read().splitlines()
    if again["error"]:
        bad = output[again["error"]["line"] - 1] if 0 < again["error"]["line"] <= len(output) else b""
        return Verdict(path, "differs", f"the output is not accepted, line {again['error']['line']} {bad!r}: {again['error']['text']}")
    if not moves(before):
        return Verdict(path, "no moves", "")
    with open(path, "rb") as file:
        lines = file.read().splitlines()
    inverse_time = any(b"G93" in line.upper() for line in lines)
    text = differ_corrected(before, judge_steps(again), model, lines, inverse_time)
    return Verdict(path, "differs" if text else "agrees", text or "")


def check_roundtrip(path, setup):
    return check_corrected(path, setup, {})


def check_model(path, setup):
    return check_corrected(path, setup, MODEL)


def way_of(answer, text):
    """Straight pieces of the moves: start, end, and whether they lie between the block of G41 or G42 and that of G40."""
    inside, is_on = {}, False
    for number, line in enumerate(text.decode("ascii", "replace").upper().splitlines(), 1):
        inside[number] = is_on and "G40" not in line
        is_on = bool(re.search("G4[12]", line)) or is_on and "G40" not in line
    pieces, place = [], None
    for step in judge_steps(answer):
        if step.kind not in ("G0", "G1", "ARC"):
            continue
        points = sampled(step, place, 2e-4) if step.kind == "ARC" else [step.place]
        for point in points:
            if place:
                pieces.append((place[:3], point[:3], inside.get(step.line, False)))
            place = point
    return pieces


def off_way(one, other, wear):
    """The first point of the pieces that is too far off other ones, and how far. The way onto the contour and off it may differ by the wear."""
    was_inside = False
    for start, end, inside in one:
        count = max(1, math.ceil(math.dist(start, end) / 0.2))
        for k in range(count):
            point = [a + (b - a) * k / count for a, b in zip(start, end)]
            near_by = (piece for piece in other if min(piece[0][0], piece[1][0]) - 0.1 < point[0] < max(piece[0][0], piece[1][0]) + 0.1)
            off = min((distance(point, *piece[:2]) for piece in near_by), default=math.inf)
            allowed = WEAR_TOLERANCE
            if not inside or k == 0 and not was_inside:
                allowed += abs(wear)
            elif k == 0 and wear < 0:
                # Around its inner corner the tool goes by an arc of the wear.
                allowed += 0.42 * abs(wear)
            if off > allowed:
                return f"{show(point)} is {off:.4f} mm off the other way"
        was_inside = inside
    return None


def check_wear(path, setup):
    """With --compensation wear and wear alone in the tool table the interpreter goes where it goes with the whole radius and the original."""
    with tempfile.TemporaryDirectory() as folder:
        out, table = os.path.join(folder, os.path.basename(path)), os.path.join(folder, "tools.json")
        command = [setup.ncfix, path, "-o", out, "--dialect", "rs274", "--machine", setup.machine, "--compensation", "wear", "--largest-wear", "0.06mm"]
        done = run(command, setup.seconds)
        if done is None or done.returncode != 0:
            return Verdict(path, *refused(done))
        for wear in WEARS:
            ways = []
            for text, share in ((path, 1.0), (out, 0.0)):
                with open(table, "w", encoding="utf-8") as file:
                    json.dump([{**tool, "diameter_mm": share * tool["diameter_mm"] + 2 * wear} for tool in tools()], file)
                answer = ask_judge(text, setup._replace(tool_file=table))
                if answer["error"]:
                    return Verdict(path, "differs", f"wear {wear}, line {answer['error']['line']}: {answer['error']['text']}")
                with open(text, "rb") as file:
                    ways.append(way_of(answer, file.read()))
            for one, other in (ways, ways[::-1]):
                difference = off_way(one, other, wear)
                if difference:
                    return Verdict(path, "differs", f"wear {wear}: {difference}")
    return Verdict(path, "agrees", "")


CHECKS = {"snc": check_snc, "roundtrip": check_roundtrip, "model": check_model, "wear": check_wear}

Setup = collections.namedtuple("Setup", "ncfix machine tool_file seconds")

MACHINE_TOOL = "\n[[tool]]\nnumber = {number}\nlength_mm = {length_mm}\nradius_mm = {radius_mm}\n"


def machine_file(folder, template, model):
    """The machine file with the tools and the errors, in `folder`."""
    with open(template, encoding="utf-8") as file:
        text = file.read()
    text += "".join(MODEL_TEXT.format(axis, *values) for axis, values in model.items())
    text += "".join(MACHINE_TOOL.format(radius_mm=tool["diameter_mm"] / 2, **tool) for tool in tools())
    path = os.path.join(folder, "machine.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def programs(paths):
    for path in paths:
        if os.path.isfile(path):
            yield path
        for folder, folders, names in os.walk(path):
            # Programs that are meant to be refused.
            folders[:] = sorted(name for name in folders if name != "bad")
            for name in sorted(names):
                if name.lower().endswith(ENDINGS) or re.fullmatch(r"[Oo]\d+", name):
                    yield os.path.join(folder, name)


def exceptions():
    """Patterns of paths with the reason why they are not compared or differ on purpose."""
    with open(os.path.join(HERE, "exceptions.tsv"), encoding="utf-8") as file:
        rows = [line.rstrip("\n").split("\t") for line in file if line.strip() and not line.startswith("#")]
    return [row for row in rows if len(row) == 2]


def reason(verdict, rows):
    if verdict.outcome not in ("differs", "refused"):
        return None
    return next((why for pattern, why in rows if fnmatch.fnmatch(verdict.path, pattern)), None)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("paths", nargs="+")
    arguments.add_argument("--mode", choices=CHECKS, default="snc")
    arguments.add_argument("--ncfix", default="ncfix")
    arguments.add_argument("--machine", default=os.path.join(HERE, "machine.toml"), help="machine file without tools")
    arguments.add_argument("--threshold", type=float, default=100.0, help="per cent of the accepted programs that must agree")
    arguments.add_argument("--seconds", type=float, default=20.0, help="time for one program on either side")
    arguments.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments.add_argument("--all", action="store_true", help="print every program, not only those that do not agree")
    options = arguments.parse_args()
    rows = exceptions()
    with tempfile.TemporaryDirectory() as folder:
        tool_file = os.path.join(folder, "tools.json")
        with open(tool_file, "w", encoding="utf-8") as file:
            json.dump(tools(), file)
        setup = Setup(options.ncfix, machine_file(folder, options.machine, MODEL if options.mode == "model" else {}), tool_file, options.seconds)
        check = CHECKS[options.mode]
        counts = collections.Counter()
        begun, done = time.monotonic(), 0
        # As they come: what differs is of use long before the last program is through.
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for verdict in pool.map(lambda path: check(path, setup), programs(options.paths)):
                why = reason(verdict, rows)
                outcome = "explained" if why else verdict.outcome
                counts[outcome] += 1
                counts["of them refused"] += outcome == "no moves" and verdict.text != ""
                if options.all or outcome in ("differs", "refused", "broken", "explained"):
                    print(f"{outcome}\t{verdict.path}\t{verdict.text}" + (f"\t({why})" if why else ""), flush=True)
                done += 1
                if done % 50 == 0 and time.monotonic() - begun > PATIENCE:
                    print(f"{options.mode}: {done} programs", file=sys.stderr, flush=True)
    accepted = sum(counts[name] for name in ("agrees", "differs", "refused", "broken", "explained"))
    share = 100.0 * counts["agrees"] / accepted if accepted else 100.0
    print(f"{options.mode}: {accepted} accepted programs with moves, {counts['agrees']} agree ({share:.1f} %), {counts['differs']} differ, "
          f"{counts['refused']} refused, {counts['broken']} broken, {counts['explained']} explained; "
          f"{counts['no moves']} without moves ({counts['of them refused']} of them refused), {counts['not accepted']} not accepted by the interpreter")
    sys.exit(0 if share >= options.threshold and not counts["broken"] else 1)


if __name__ == "__main__":
    main()
