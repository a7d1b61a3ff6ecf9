"""OctoPrint's virtual printer (Marlin) at the end of a pseudo-terminal, without OctoPrint's server.

Usage: virtual_printer.py LINK SETTINGS-AS-JSON [RECORD]. LINK becomes a symbolic link to the terminal; "ready" is printed when it is there. What the
printer carries out is written to RECORD, one command a line. A setting more than it has itself, "unheard", names lines that it loses when they come
for the first time. Ends when the last one who had the terminal open is gone.
"""

import json
import os
import pty
import select
import sys
import tempfile
import threading
import tty

import octoprint.plugin
from octoprint.plugins.virtual_printer import VirtualPrinterPlugin

LINK, GIVEN = sys.argv[1], json.loads(sys.argv[2])
RECORD = sys.argv[3] if len(sys.argv) > 3 else os.devnull


class NoHooks:
    def get_hooks(self, _name):
        return {}


octoprint.plugin.plugin_manager = lambda: NoHooks()
from octoprint.plugins.virtual_printer import virtual  # noqa: E402  it takes the manager of plugins by name

virtual.plugin_manager = octoprint.plugin.plugin_manager


class Settings:
    """The defaults of the plugin with what was given on top."""

    def __init__(self):
        self.values = {**VirtualPrinterPlugin.get_settings_defaults(None), **GIVEN}

    def get(self, path, **_options):
        value = self.values
        for key in path:
            value = value.get(key) if isinstance(value, dict) else None
        return value

    def get_int(self, path, **_options):
        return int(self.get(path) or 0)

    def get_float(self, path, **_options):
        return float(self.get(path) or 0)

    def get_boolean(self, path, **_options):
        return bool(self.get(path))

    def global_get_basefolder(self, _name):
        return tempfile.mkdtemp()


class Profiles:
    def get_current_or_default(self):
        return {"axes": {axis: {"inverted": False} for axis in "xyze"}}


class Printer(virtual.VirtualPrinter):
    """Writes down what it carries out, in the order in which it does."""

    unheard = list(GIVEN.pop("unheard", []))
    record = open(RECORD, "w", encoding="ascii", errors="replace", buffering=1)

    def write(self, data):
        for number in self.unheard:
            if data.startswith(b"N%d " % number):
                self.unheard.remove(number)
                self._dont_answer = True
                break
        return super().write(data)

    def _performMove(self, line):
        self.record.write(line.strip() + "\n")
        return super()._performMove(line)


def main():
    control, terminal = pty.openpty()
    tty.setraw(control)
    tty.setraw(terminal)
    printer = Printer(Settings(), Profiles(), tempfile.mkdtemp(), read_timeout=0.5)
    if os.path.islink(LINK):
        os.unlink(LINK)
    os.symlink(os.ttyname(terminal), LINK)
    os.close(terminal)
    print("ready", flush=True)

    def talk():
        while True:
            line = printer.readline()
            if line:
                data = line if line.endswith(b"\n") else line + b"\n"
                while data:
                    try:
                        data = data[os.write(control, data) :]
                    except OSError:
                        return

    threading.Thread(target=talk, daemon=True).start()
    was_open = False
    while True:
        select.select([control], [], [], 0.2)
        try:
            data = os.read(control, 1024)
        except OSError:
            # Nobody has it open: not yet, or not any more.
            if was_open:
                break
            threading.Event().wait(0.05)
            continue
        was_open = True
        while data:
            data = data[printer.write(data) :]
    os.unlink(LINK)
    os._exit(0)


main()
