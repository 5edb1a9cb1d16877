"""Writes double_clear.xml: two uncoated panes of clear glass, 4 mm each, 16 mm apart.

Fresnel's equations for both polarisations and Bouguer's law inside each pane (n = 1.526,
absorption 9 per metre), interreflections within and between the panes summed exactly; each Klems
bin gets the mean over its projected solid angle. Light goes straight through, so only the diagonal
is filled: BTDF = transmittance / projected solid angle. Run: python3 double_clear.py > double_clear.xml
"""

from math import acos, asin, cos, exp, pi, radians, sin, sqrt

INDEX, ABSORPTION, THICKNESS = 1.526, 9.0, 0.004
RINGS = [(0, 5, 1), (5, 15, 8), (15, 25, 16), (25, 35, 20), (35, 45, 24), (45, 55, 24), (55, 65, 24), (65, 75, 16), (75, 90, 12)]


def pane(r, tau):
    """Transmittance and reflectance of a pane from one surface's reflectance and one pass."""
    t = (1 - r) ** 2 * tau / (1 - (r * tau) ** 2)
    return t, r * (1 + t * tau)


def optics(theta):
    """Transmittance and reflectance of the two panes at an angle of incidence (radians)."""
    inner = asin(sin(theta) / INDEX)
    tau = exp(-ABSORPTION * THICKNESS / cos(inner))
    a, b = cos(theta), cos(inner)
    total_t = total_r = 0.0
    for r in (((a - INDEX * b) / (a + INDEX * b)) ** 2, ((b - INDEX * a) / (b + INDEX * a)) ** 2):
        t, q = pane(r, tau)
        total_t += 0.5 * t * t / (1 - q * q)
        total_r += 0.5 * (q + t * t * q / (1 - q * q))
    return total_t, total_r


def ring_mean(low, high, which, steps=2000):
    """Mean over a ring, uniform in projected solid angle (cos² of the polar angle)."""
    c0, c1 = cos(radians(low)) ** 2, (cos(radians(high)) ** 2 if high < 90 else 0.0)
    return sum(optics(acos(sqrt(c0 + (c1 - c0) * (i + 0.5) / steps)))[which] for i in range(steps)) / steps


def matrix(which):
    diagonal = []
    for low, high, n in RINGS:
        c1 = cos(radians(high)) ** 2 if high < 90 else 0.0
        solid = pi * (cos(radians(low)) ** 2 - c1) / n
        diagonal += [ring_mean(low, high, which) / solid] * n
    size = len(diagonal)
    return "\n".join(" ".join(f"{diagonal[i]:.6g}" if i == j else "0" for j in range(size)) for i in range(size))


BLOCK = """		<WavelengthData>
			<LayerNumber>System</LayerNumber>
			<Wavelength unit="Integral">Visible</Wavelength>
			<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>
			<DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>
			<WavelengthDataBlock>
				<WavelengthDataDirection>{0}</WavelengthDataDirection>
				<ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis>
				<RowAngleBasis>LBNL/Klems Full</RowAngleBasis>
				<ScatteringDataType>{1}</ScatteringDataType>
				<ScatteringData>
{2}
				</ScatteringData>
			</WavelengthDataBlock>
		</WavelengthData>"""

rings = "\n".join(
    f"""				<AngleBasisBlock>
					<Theta>{(low + high) / 2 if low else 0:g}</Theta>
					<nPhis>{n}</nPhis>
					<ThetaBounds>
						<LowerTheta>{low}</LowerTheta>
						<UpperTheta>{high}</UpperTheta>
					</ThetaBounds>
				</AngleBasisBlock>"""
    for low, high, n in RINGS
)
t, r = matrix(0), matrix(1)
blocks = "\n".join(
    BLOCK.format(name, kind, data)
    for name, kind, data in [
        ("Transmission Front", "BTDF", t),
        ("Transmission Back", "BTDF", t),
        ("Reflection Front", "BRDF", r),
        ("Reflection Back", "BRDF", r),
    ]
)
print(f"""<?xml version="1.0" encoding="UTF-8"?>
<!-- Made by double_clear.py, which says how. MIT OR Apache-2.0. -->
<WindowElement xmlns="http://windows.lbl.gov" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://windows.lbl.gov/BSDF-v1.4.xsd">
<WindowElementType>System</WindowElementType>
<FileType>BSDF</FileType>
<Optical>
	<Layer>
		<Material>
			<Name>Double clear glazing 4-16-4</Name>
			<Manufacturer>Lucarne</Manufacturer>
			<DeviceType>Other</DeviceType>
			<Thickness unit="meter">0.024</Thickness>
		</Material>
		<DataDefinition>
			<IncidentDataStructure>Columns</IncidentDataStructure>
			<AngleBasis>
				<AngleBasisName>LBNL/Klems Full</AngleBasisName>
{rings}
			</AngleBasis>
		</DataDefinition>
{blocks}
	</Layer>
</Optical>
</WindowElement>""")
