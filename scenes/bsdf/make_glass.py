#!/usr/bin/env python3
"""Spectra of two panes of this project's own making, in the text format of Optics.

clear_float.dat: a slab 6 mm thick. Index of refraction by Rubin's fit to soda-lime glass (Solar
Energy Materials 12, 1985); absorption of two broad bands (iron) and an ultraviolet edge, chosen to
look like float glass.
low_e.dat: the same slab before an idealised metal layer that passes two thirds of the light up to
about 0.7 um and is a mirror beyond; the layer lies on the back.

    python3 make_glass.py      # writes the two files beside itself
"""
import math
from pathlib import Path

WAVELENGTHS = (
    [k / 1000 for k in range(300, 400, 5)] + [k / 1000 for k in range(400, 1000, 10)] + [k / 1000 for k in range(1000, 2501, 50)]
)


def index(w):
    return 1.5130 - 0.003169 * w * w + 0.003962 / (w * w)


def absorption(w):
    """Per metre."""
    ultraviolet = 900 / (1 + math.exp((w - 0.318) / 0.008))
    iron = 38 * math.exp(-(((w - 1.08) / 0.34) ** 2)) + 6 * math.exp(-(((w - 0.38) / 0.01) ** 2))
    return 2.0 + ultraviolet + iron


def slab(w, thickness):
    face = ((index(w) - 1) / (index(w) + 1)) ** 2
    inside = math.exp(-absorption(w) * thickness)
    t = (1 - face) ** 2 * inside / (1 - (face * inside) ** 2)
    return t, face + face * inside * t


def low_e(w, thickness):
    mirror = 1 / (1 + math.exp(-(w - 0.95) / 0.14))
    layer_t, layer_r = 0.68 * (1 - mirror), 0.06 + 0.90 * mirror
    face = ((index(w) - 1) / (index(w) + 1)) ** 2
    inside = math.exp(-absorption(w) * thickness)
    # Front face, glass, then the layer, which reflects the same from both sides.
    d = 1 - face * layer_r * inside**2
    t = (1 - face) * inside * layer_t / d
    front = face + (1 - face) ** 2 * inside**2 * layer_r / d
    back = layer_r + layer_t**2 * inside**2 * face / d
    return t, front, back


def write(name, title, coated, thickness, rows):
    side = "Back" if coated else "Neither"
    head = [
        "{ Units, Wavelength Units } SI Microns",
        f"{{ Thickness }} {thickness * 1000:g}",
        "{ Conductivity } 1",
        "{ IR Transmittance } TIR=0",
        f"{{ Emissivity, front back }} Emis= 0.84 {0.04 if coated else 0.84}",
        "{ }",
        f"{{ Product Name: {title} }}",
        "{ Manufacturer: nobody }",
        f"{{ Type: {'Coated' if coated else 'Monolithic'} }}",
        "{ Material: Glass }",
        f"{{ Coated Side: {side} }}",
    ]
    lines = [f"{w:.3f}\t{t:.4f}\t{f:.4f}\t{b:.4f}" for w, t, f, b in rows]
    (Path(__file__).parent / name).write_text("\n".join(head + lines) + "\n")


clear = [(w, *slab(w, 0.006), slab(w, 0.006)[1]) for w in WAVELENGTHS]
write("clear_float.dat", "clear float, computed", False, 0.006, clear)
write("low_e.dat", "idealised low-e, computed", True, 0.006, [(w, *low_e(w, 0.006)) for w in WAVELENGTHS])
