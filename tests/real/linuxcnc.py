"""A person at LinuxCNC, for tests: switches it on, homes it, reads its position, ends it. Speaks linuxcncrsh.

Usage: linuxcnc.py PORT ready|position|shutdown, or linuxcnc.py program COUNT FILE [BAD]
"""

import socket
import sys
import time


class Shell:
    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=30)
        self.rest = b""
        for command in ("hello EMC person 1.0", "set echo off", "set verbose on", "set enable EMCTOO"):
            self.socket.sendall(command.encode() + b"\r\n")
            time.sleep(0.2)
        self.read_until("SET ENABLE ACK")

    def read_until(self, *begins):
        end = time.monotonic() + 30
        while time.monotonic() < end:
            line, found, rest = self.rest.replace(b"\r", b"\n").partition(b"\n")
            if found:
                self.rest = rest
                if line.decode().startswith(begins):
                    return line.decode()
                continue
            data = self.socket.recv(4096)
            if not data:
                break
            self.rest += data
        sys.exit(f"LinuxCNC does not say {begins}")

    def ask(self, command, *begins):
        self.socket.sendall(command.encode() + b"\r\n")
        return self.read_until(*begins)


def ready(shell):
    shell.ask("set estop off", "SET ESTOP")
    shell.ask("set machine on", "SET MACHINE")
    shell.ask("set mode manual", "SET MODE")
    shell.ask("set home -1", "SET HOME")
    for _ in range(100):
        homed = shell.ask("get joint_homed", "JOINT_HOMED").split()
        if homed[1:4] == ["YES"] * 3:
            return
        time.sleep(0.1)
    sys.exit("LinuxCNC does not home")


def program(count, path, bad):
    """Every move has a length of its own; where the last ones of each axis lead is where they are at the end."""
    end = [0.0, 0.0, 0.0]
    with open(path, "w", encoding="ascii") as file:
        file.write("G21 G17 G90 G94\nG0 X0 Y0 Z0\nM3 S500\nG91\n")
        for k in range(count):
            if k == bad:
                # Beyond the limits of the simulator, which the machine file does not know.
                file.write("G1 X900 F6000\n")
                continue
            axis = k % 3
            micrometres = (k * k % 997 + 1) * (1 if end[axis] < 1 else -1)
            end[axis] += micrometres / 1000
            file.write(f"G1 {'XYZ'[axis]}{micrometres / 1000:.3f} F6000\n")
        file.write("G90\nM5\nM30\n")
    print(*(f"{value:.6f}" for value in end))


def main():
    if sys.argv[1] == "program":
        bad = int(sys.argv[4]) if len(sys.argv) > 4 else -1
        program(int(sys.argv[2]), sys.argv[3], bad)
        return
    shell = Shell(int(sys.argv[1]))
    if sys.argv[2] == "ready":
        ready(shell)
    elif sys.argv[2] == "position":
        print(*shell.ask("get abs_act_pos", "ABS_ACT_POS").split()[1:4])
    else:
        shell.socket.sendall(b"shutdown\r\n")
        time.sleep(1)


main()
