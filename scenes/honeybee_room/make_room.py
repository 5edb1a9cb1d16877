"""Writes room.hbjson beside this file, and model/, the same as honeybee-radiance writes it for Radiance:

    python3 make_room.py        # pip install honeybee-radiance==1.66.299

An office of 4 m x 6 m x 2.8 m that looks south, and behind it a corridor of 4 m x 2 m. In it is about
everything that a Honeybee model can hold: own modifiers, a modifier set, generic modifiers; a wall between
two rooms with a door and a pane in it; apertures of plain glass (two in one plane), of a BSDF and of a dynamic
group; a glass door; shades inside, outside and apart; a mesh; sensor grids and a view.
"""
import os
import re
import tempfile

from honeybee.aperture import Aperture
from honeybee.boundarycondition import boundary_conditions as bcs
from honeybee.door import Door
from honeybee.face import Face
from honeybee.model import Model
from honeybee.room import Room
from honeybee.shade import Shade
from honeybee.shademesh import ShadeMesh
from honeybee_radiance.dynamic.state import RadianceSubFaceState
from honeybee_radiance.modifier.material import BSDF, Glass, Metal, Mirror, Plastic, Trans
from honeybee_radiance.modifierset import ModifierSet
from honeybee_radiance.sensorgrid import SensorGrid
from honeybee_radiance.view import View
from honeybee_radiance.writer import model_to_rad_folder
from ladybug_geometry.geometry3d.face import Face3D
from ladybug_geometry.geometry3d.mesh import Mesh3D
from ladybug_geometry.geometry3d.pointvector import Point3D, Vector3D

HERE = os.path.dirname(os.path.abspath(__file__))


def face3d(*points):
    return Face3D([Point3D(*p) for p in points])


def upright(y, x0, x1, z0, z1, south=True):
    """A rectangle in the plane y, its front to the south or north."""
    corners = [(x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)]
    return face3d(*(corners if south else corners[::-1]))


def aperture(name, geometry, modifier=None, kind=Aperture, **more):
    made = kind(name, geometry, **more)
    if modifier is not None:
        made.properties.radiance.modifier = modifier
    return made


def blind():
    """The venetian blind of scenes/bsdf: its visible transmission, to three digits."""
    with open(os.path.join(HERE, '../bsdf/venetian.xml'), encoding='utf-8') as file:
        text = file.read()
    blocks = re.findall(r'<WavelengthData>.*?</WavelengthData>', text, re.S)
    for block in blocks:
        if 'Transmission' not in block or '>Visible<' not in block:
            text = text.replace(block, '')
    text = re.sub(r'\d+\.\d+(e-?\d+)?', lambda m: '%.3g' % float(m.group()), text)
    path = os.path.join(tempfile.mkdtemp(), 'blind.xml')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(re.sub(r'\n\s*\n+', '\n', text))
    return BSDF(path, 'blind', up_orientation=(0, 0, 1))


def face(room, x, y, z):
    return next(f for f in room.faces if f.normal.dot(Vector3D(x, y, z)) > 0.99)


office = Room.from_box('Office', 4, 6, 2.8)
corridor = Room.from_box('Corridor', 4, 2, 2.8, origin=Point3D(0, 6, 0))
office.display_name = 'Office, south'

# Two panes in one plane, by the set of the room; one of them has its corners the wrong way round.
clear = Glass('clear_double', 0.8, 0.82, 0.79, refraction_index=1.52)
light_walls = Plastic('light_walls', 0.7, 0.68, 0.6)
warm = ModifierSet('warm')
warm.wall_set.interior_modifier = light_walls
warm.wall_set.exterior_modifier = light_walls
warm.aperture_set.window_modifier = clear
office.properties.radiance.modifier_set = warm
south = face(office, 0, -1, 0)
south.add_aperture(aperture('south_left', upright(0, 0.5, 1.7, 0.9, 2.3)))
south.add_aperture(aperture('south_right', upright(0, 2.0, 2.8, 0.9, 2.3)))
# A pane that darkens, and a door of glass.
tint = [Glass('tint_clear', 0.65, 0.65, 0.65), Glass('tint_dark', 0.1, 0.12, 0.14)]
switchable = aperture('switchable', upright(0, 3.0, 3.8, 0.9, 2.3))
switchable.properties.radiance.dynamic_group_identifier = 'facade'
switchable.properties.radiance.states = [RadianceSubFaceState(m) for m in tint]
south.add_aperture(switchable)
west = face(office, -1, 0, 0)
west.add_aperture(aperture('west_blind', face3d((0, 3, 1), (0, 2, 1), (0, 2, 2), (0, 3, 2)), blind()))
east = face(office, 1, 0, 0)
east.add_door(aperture('terrace', face3d((4, 1, 0.02), (4, 2, 0.02), (4, 2, 2.1), (4, 1, 2.1)), kind=Door, is_glass=True))
# The wall to the corridor, with a door and a pane; each side has its own colour.
for room, front in ((office, False), (corridor, True)):
    wall = face(room, 0, -1 if front else 1, 0)
    name = room.identifier
    wall.add_aperture(aperture(name + '_pane', upright(6, 2, 3.5, 1, 2, front)))
    wall.add_door(aperture(name + '_door', upright(6, 0.5, 1.5, 0.02, 2.1, front), kind=Door))
Room.solve_adjacency([office, corridor], 0.01)
face(office, 0, 0, -1).properties.radiance.modifier = Metal('steel_floor', 0.4, 0.4, 0.42, 0.9, 0.1)
# A roof light that can be opened, the generic modifier.
face(corridor, 0, 0, 1).add_aperture(
    aperture('roof_light', face3d((1, 6.5, 2.8), (3, 6.5, 2.8), (3, 7.5, 2.8), (1, 7.5, 2.8)), is_operable=True))

# Shades: an overhang, a light shelf and a mirror on the wall, a table, a house across the street, a tree, a hedge.
south.apertures[0].overhang(0.6, indoor=False)
shelf = Shade('shelf', face3d((0.5, 0, 1.9), (1.7, 0, 1.9), (1.7, 0.4, 1.9), (0.5, 0.4, 1.9)))
shelf.properties.radiance.modifier = Mirror('polished', 0.85, 0.85, 0.85)
south.apertures[0].add_indoor_shade(shelf)
table_top = Face3D([Point3D(*p) for p in ((1, 2, 0.75), (3, 2, 0.75), (3, 3, 0.75), (1, 3, 0.75))],
                   holes=[[Point3D(*p) for p in ((1.8, 2.4, 0.75), (2.2, 2.4, 0.75), (2.2, 2.6, 0.75), (1.8, 2.6, 0.75))]])
office.add_indoor_shade(Shade('table', table_top))
house = Shade('house', face3d((-6, -10, 0), (6, -10, 0), (6, -10, 7), (-6, -10, 7)), is_detached=True)
awning = Shade('awning', face3d((3, -1, 2.5), (4, -1, 2.5), (4, 0, 2.5), (3, 0, 2.5)))
awning.properties.radiance.modifier = Trans('canvas', 0.6, 0.5, 0.4, 0, 0, 0.3, 0.1)
hedge = ShadeMesh('hedge', Mesh3D([Point3D(*p) for p in ((4.5, -3, 0), (6.5, -3, 0), (6.5, -3, 1.5), (4.5, -3, 1.5), (5.5, -4, 1.5))],
                                  [(0, 1, 2, 3), (3, 2, 4)]))

# Sensors of both rooms, and who sits in the office.
grid = office.properties.radiance.generate_sensor_grid(1, 1, 0.8)
grid.identifier = 'Workplane'
view = View('desk', (2, 5, 1.2), (0, -1, 0), (0, 0, 1), 'h', 180, 180)
model = Model('Two_Rooms', [office, corridor], orphaned_shades=[house, awning], shade_meshes=[hedge], tolerance=0.01)
model.properties.radiance.add_sensor_grids([grid, corridor.properties.radiance.generate_sensor_grid(1, 1, 0.8)])
model.properties.radiance.add_view(view)
model.to_hbjson('room', HERE, indent=None)
model_to_rad_folder(model, HERE, minimal=True)
