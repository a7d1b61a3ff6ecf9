#!/usr/bin/python3
"""judge.py FILE [--block-delete] [--tools FILE] [--any-feed]: what LinuxCNC's interpreter makes of a program, as JSON on standard output.

Needs the Python module `gcode` of Debian's linuxcnc-uspace, which brings the interpreter in as a library: full precision and no
text in between. The answer is one object:

  elements  list of what the interpreter orders, in its order:
              ["G0", line, position, tool]              rapid
              ["G1", line, position, tool, feed]        straight feed
              ["ARC", line, position, tool, feed, center, plane, turns, rotation]   turns < 0: clockwise; |turns| > 1: more than one
                  round; rotation about Z of the plane, rad
              ["PROBE", line, position, tool, feed]     probing move, to its programmed end
              ["TAP", line, position, tool, feed]       rigid tapping: to this point and back
              ["DWELL", line, seconds], ["TOOL", line, number], ["MESSAGE", line, text], ["M", line, number, p, q]
            position: X Y Z A B C U V W of the controlled point in machine coordinates, mm and degrees, with zero offset, G92 and the
            rotation of G10 applied; tool: offset in force along the axes, so that axis command = position + tool.
            feed: mm/min as the interpreter sets it (in G93 it has made a rate of it), per turn in G95.
  error     null, or {"line": …, "text": …}: the program is not accepted; elements are those before the error.

The module always counts lengths in inches. It reads tools from memory shared between processes, kept in the home folder: hence
a home folder of our own.

Behind a tool change and a probing move the interpreter asks where the machine is. The module answers with the end of the last
straight move, in the coordinates that were in force then: wrong behind an arc, and where a length offset or zero offset has changed
meanwhile, as in `T1 M6 G43`. A machine knows better; so the answer is put right here (class Memory).
"""

import argparse
import ctypes
import json
import math
import os
import shutil
import sys
import tempfile

MM_PER_INCH = 25.4
CALLBACKS_OF_NO_INTEREST = ("comment", "set_traverse_rate", "set_feed_mode")


def write_tool_table(path, tools):
    with open(path, "w", encoding="ascii") as out:
        for tool in tools:
            out.write(f"T{tool['number']} P{tool['number']} Z{tool['length_mm']:.9f} D{tool['diameter_mm']:.9f}\n")


def load_tools(table):
    """Puts the tool table where the interpreter, which is loaded by now, looks for it."""
    with open("/proc/self/maps", encoding="ascii") as maps:
        path = next(line.split()[-1] for line in maps if "libtooldata" in line)
    library = ctypes.CDLL(path)
    library._Z17tool_mmap_creatorPK13EMC_TOOL_STATi(None, 0)
    library._Z13tooldata_initb(0)
    library._Z13tooldata_loadPKcPPc(table.encode(), None)


class Memory:
    """Where the module keeps the position that it tells the interpreter: the variables that GET_EXTERNAL_POSITION_X and its kin load."""

    LOADS_AND_RETURNS = bytes.fromhex("f20f1005")

    def __init__(self, path):
        library = ctypes.CDLL(path)
        self.slots = []
        for axis in "XYZABCUVW":
            try:
                function = ctypes.cast(getattr(library, f"_Z23GET_EXTERNAL_POSITION_{axis}v"), ctypes.c_void_p).value
            except AttributeError:
                continue
            code = ctypes.string_at(function, 13)
            at = 4 if code.startswith(bytes.fromhex("f30f1efa")) else 0  # endbr64
            if code[at : at + 4] == self.LOADS_AND_RETURNS and code[at + 8] == 0xC3:
                offset = int.from_bytes(code[at + 4 : at + 8], "little", signed=True)
                self.slots.append(ctypes.c_double.from_address(function + at + 8 + offset))
        if len(self.slots) < 9:
            print("judge.py: the module keeps positions in another way than expected", file=sys.stderr)
            self.slots = []

    def write(self, values):
        for slot, value in zip(self.slots, values):
            slot.value = value


class Listener:
    """Takes the calls of the interpreter."""

    def __init__(self, tools, parameter_file, block_delete):
        self.tools = {tool["number"]: tool for tool in tools}
        self.pockets = [-1] + [tool["number"] for tool in tools]
        self.parameter_file = parameter_file
        self.block_delete = block_delete
        self.elements = []
        self.line = 0
        self.feed = 0.0
        self.plane = 17
        self.zero = [0.0] * 9
        self.shift = [0.0] * 9
        self.turn = 0.0
        self.tool = [0.0] * 9
        self.command = [0.0] * 9
        self.metric = True
        self.memory = None
        for name in CALLBACKS_OF_NO_INTEREST:
            setattr(self, name, lambda *_: None)

    # ── settings ──

    def next_line(self, state):
        self.line = state.sequence_number
        self.metric = state.gcodes[5] == 210

    def set_plane(self, plane):
        self.plane = {1: 17, 2: 19, 3: 18}.get(plane, plane)

    def set_feed_rate(self, rate):
        self.feed = rate * MM_PER_INCH

    def set_g5x_offset(self, _index, *offset):
        self.zero = list(offset)
        self.put_right()

    def set_g92_offset(self, *offset):
        self.shift = list(offset)
        self.put_right()

    def set_xy_rotation(self, degrees):
        self.turn = math.radians(degrees)
        self.put_right()

    def tool_offset(self, *offset):
        self.tool = list(offset)
        self.put_right()

    def change_tool(self, pocket):
        number = self.pockets[pocket] if 0 <= pocket < len(self.pockets) else pocket
        self.pockets[0] = number
        self.elements.append(["TOOL", self.line, number])
        self.put_right()

    # ── what is ordered ──

    def put_right(self):
        """Tells the module where the program is, in the coordinates in force and the units of the program."""
        if self.memory is None:
            return
        point = [value - tool - zero for value, tool, zero in zip(self.command, self.tool, self.zero)]
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        point[0], point[1] = cos * point[0] + sin * point[1], cos * point[1] - sin * point[0]
        point = [value - shift for value, shift in zip(point, self.shift)]
        self.memory.write(self.millimeters(point) if self.metric else point)

    def place(self, values):
        """Machine coordinates of a programmed point, mm and degrees."""
        return self.millimeters(self.turned(values))

    def turned(self, values):
        point = [value + shift for value, shift in zip(values, self.shift)]
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        point[0], point[1] = cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]
        return [value + zero for value, zero in zip(point, self.zero)]

    @staticmethod
    def millimeters(values):
        return [value if 3 <= slot < 6 else value * MM_PER_INCH for slot, value in enumerate(values)]

    def motion(self, kind, values, *more):
        self.elements.append([kind, self.line, self.place(values), self.millimeters(self.tool), *more])
        if kind != "TAP":
            self.command = [value + tool for value, tool in zip(self.turned(values), self.tool)]
        if kind == "ARC":
            self.put_right()

    def straight_traverse(self, *values):
        self.motion("G0", values)

    def straight_feed(self, *values):
        self.motion("G1", values, self.feed)

    def straight_probe(self, *values):
        self.motion("PROBE", values, self.feed)

    def rigid_tap(self, x, y, z):
        self.motion("TAP", (x, y, z, 0, 0, 0, 0, 0, 0), self.feed)

    def arc_feed(self, end_1, end_2, center_1, center_2, turns, end_3, *rest):
        order = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}[self.plane]
        end, center = [0.0] * 3, [0.0] * 3
        for slot, to, about in zip(order, (end_1, end_2, end_3), (center_1, center_2, end_3)):
            end[slot], center[slot] = to, about
        middle = self.place([*center, *rest])[:3]
        self.motion("ARC", [*end, *rest], self.feed, middle, self.plane, turns, self.turn)

    def dwell(self, seconds):
        self.elements.append(["DWELL", self.line, seconds])

    def message(self, text):
        self.elements.append(["MESSAGE", self.line, text])

    def user_defined_function(self, number, p, q):
        self.elements.append(["M", self.line, 100 + number, p, q])

    user_defined_program = user_defined_function

    # ── what the interpreter asks for ──

    def get_external_length_units(self):
        return 1.0

    def get_external_angular_units(self):
        return 1.0

    def get_axis_mask(self):
        return 0x3F  # X to C, as the machine of the comparison

    def get_block_delete(self):
        return self.block_delete

    def check_abort(self):
        return False

    def get_tool(self, pocket):
        number = self.pockets[pocket] if 0 <= pocket < len(self.pockets) else -1
        tool = self.tools.get(number)
        if tool is None:
            return (-1,) + (0.0,) * 12 + (0,)
        return (number, 0.0, 0.0, tool["length_mm"]) + (0.0,) * 6 + (tool["diameter_mm"], 0.0, 0.0, 0)


def parameters(options):
    """Text of a parameter file: one number and value a line."""
    return "".join(f"{item.split('=')[0]}\t{item.split('=')[1]}\n" for item in options)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("file")
    arguments.add_argument("--block-delete", action="store_true")
    arguments.add_argument("--tools", help="JSON: list of objects with number, length_mm, diameter_mm")
    arguments.add_argument("--parameter", action="append", default=[], help="5221=100: persistent parameter before the start")
    arguments.add_argument("--any-feed", action="store_true", help="G1 without F is no error")
    arguments.add_argument("--append-end", action="store_true", help="for programs that do not say where they end")
    options = arguments.parse_args()
    tools = []
    if options.tools:
        with open(options.tools, encoding="utf-8") as file:
            tools = json.load(file)
    program = os.path.abspath(options.file)
    folder = tempfile.mkdtemp(prefix="judge")
    try:
        os.environ["HOME"] = folder
        settings = os.path.join(folder, "judge.ini")
        with open(settings, "w", encoding="utf-8") as file:
            file.write(f"[DISPLAY]\nPROGRAM_PREFIX = {os.path.dirname(program)}\n")
            file.write(f"[RS274NGC]\nSUBROUTINE_PATH = {os.path.dirname(program)}\n")
        os.environ["INI_FILE_NAME"] = settings
        parameter_file = os.path.join(folder, "judge.var")
        with open(parameter_file, "w", encoding="utf-8") as file:
            file.write(parameters(options.parameter))
        table = os.path.join(folder, "judge.tbl")
        write_tool_table(table, tools)
        if options.append_end:
            with open(program, "rb") as file:
                text = file.read()
            program = os.path.join(folder, os.path.basename(program))
            with open(program, "wb") as file:
                file.write(text + b"\nM2\n")
        os.chdir(folder)
        # What (print, …) in a program prints must not get into the answer.
        answer_file = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        import gcode  # only now: it looks at HOME

        load_tools(table)
        listener = Listener(tools, parameter_file, options.block_delete)
        listener.memory = Memory(gcode.__file__)
        answer = {"elements": listener.elements, "error": None}
        try:
            # The module begins with a feed of one, a machine with none, and then G1 without F is an error.
            result, line = gcode.parse(program, listener, "G21", "" if options.any_feed else "F0")
            if result > gcode.MIN_ERROR:
                answer["error"] = {"line": line, "text": gcode.strerror(result)}
        except Exception as error:  # what the module raises is no more precise
            answer["error"] = {"line": listener.line, "text": f"{type(error).__name__}: {error}"}
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    json.dump(answer, answer_file)
    answer_file.close()


main()
