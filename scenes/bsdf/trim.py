#!/usr/bin/env python3
"""python3 trim.py system.xml small.xml: keeps Visible / Transmission Front, all that a run uses, to three digits (trees: to all)."""
import re
import sys


def kept(data):
    """Nothing of other bands and directions; its numbers rounded."""
    if ">Visible<" not in data or ">Transmission Front<" not in data:
        return ""
    if "Tree" in data or "Shirley" in data:
        return data
    head, numbers, tail = re.split(r"(?<=<ScatteringData>)(.*)(?=</ScatteringData>)", data, flags=re.S)[:3]
    rows = [[f"{float(v):.3g}" for v in re.split(r"[,\s]+", row) if v] for row in numbers.strip().splitlines()]
    return head + "\n" + "".join(",".join(row) + ",\n" for row in rows) + tail


with open(sys.argv[1], encoding="utf-8") as system:
    text = re.sub(r"[ \t]*<WavelengthData>.*?</WavelengthData>\n?", lambda found: kept(found[0]), system.read(), flags=re.S)
with open(sys.argv[2], "w", encoding="utf-8") as small:
    small.write(text)
