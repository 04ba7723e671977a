"""Make a new object visible: on a frame that it has, in the 3D views, not hidden in another object."""

import bpy
from mathutils import Matrix, Vector


def views():
    """The 3D views of all screens."""
    areas = (area for screen in bpy.data.screens for area in screen.areas)
    return [space for area in areas for space in area.spaces if space.type == "VIEW_3D"]


def eye(view):
    """From a view's space, which it sees along -z, to the world; right before the view is drawn again, too."""
    region = view.region_3d
    turn = region.view_rotation.to_matrix().to_4x4()
    return Matrix.Translation(region.view_location) @ turn @ Matrix.Translation((0, 0, region.view_distance))


def stage(context, thing, corners, first=None, last=None, domain=None):
    """Show a new object. Returns a description for the user, and warnings.

    @param corners  in world space  @param first, last  its frames; nothing: all of them  @param domain  that it fills
    """
    scene = context.scene
    low, high = (Vector(map(pick, zip(*corners))) for pick in (min, max))
    told = f"{thing.name}: {' x '.join(f'{side:.3g}' for side in high - low)} units"
    if first is not None:
        told += f", frames {first} to {last}"
        scene.frame_set(min(max(scene.frame_current, first), last))
    radius = (high - low).length / 2
    for view in views():
        view.region_3d.view_location, view.region_3d.view_distance = (low + high) / 2, 3 * radius
        view.clip_start, view.clip_end = min(view.clip_start, radius / 100), max(view.clip_end, 100 * radius)
    around = [other for other in scene.objects if other not in (thing, domain) and _hides(other, low, high)]
    return told, [f"{thing.name}: it stands inside {other.name}, which hides it; hide or delete that" for other in around]


def select_only(context, thing):
    for other in context.view_layer.objects:
        other.select_set(False)
    thing.select_set(True)
    context.view_layer.objects.active = thing


def _hides(other, low, high):
    if other.type != "MESH" or other.display_type in ("WIRE", "BOUNDS") or not other.visible_get():
        return False
    corners = [other.matrix_world @ Vector(corner) for corner in other.bound_box]
    axes = list(zip(*corners))
    return all(min(axis) <= a and b <= max(axis) for axis, a, b in zip(axes, low, high))
