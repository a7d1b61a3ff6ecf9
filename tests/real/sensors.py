"""Holds the last line of `ncfix sensors --watch --json` against what is expected.

Usage: sensors.py LINES.json NAME=VALUE|NAME=!PART… – the value of a channel, in °C, good at the end; or a part of the note of one that has none.
"""

import json
import sys

with open(sys.argv[1], encoding="utf-8") as file:
    lines = [json.loads(line) for line in file if line.strip()]
if not lines:
    sys.exit("ncfix said nothing")
channels = {channel["name"]: channel for channel in lines[-1]["channels"]}
wrong = 0
for word in sys.argv[2:]:
    name, expected = word.split("=", 1)
    channel = channels.pop(name)
    if expected.startswith("!"):
        is_right = channel["value_C"] is None and expected[1:] in (channel["note"] or "")
    else:
        is_right = channel["state"] == "good" and abs(channel["value_C"] - float(expected)) < 1e-6
    print("ok   " if is_right else "WRONG", name, channel["value_C"], channel["state"], channel["note"] or "")
    wrong += not is_right
if channels:
    sys.exit(f"nothing is expected of {', '.join(channels)}")
sys.exit(wrong > 0)
