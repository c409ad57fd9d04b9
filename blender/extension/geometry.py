# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces: the evaluated scene as meshes of one material each.

In the evaluated scene modifiers are applied, instances are made and libraries are linked; the viewport
shows it.
"""

import numpy as np
import unrender

from .frames import y_up

SURFACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
NO_MATERIAL = "(no material)"
INSERTED = "unrender_insert"
"""The property of objects that are to be inserted into the photograph."""


def group_name(material):
    """The group of surfaces with this material; a recovered material belongs to the group of its
    original."""
    return NO_MATERIAL if material is None else first(material).name_full


def first(material):
    """The user's own material, from which a recovered one was made."""
    return getattr(material, "unrender_original", None) or material


def unused(name, taken):
    """``name``, with a number if it is taken."""
    number, made = 1, name
    while made in taken:
        number += 1
        made = f"{name} {number}"
    return made


def surfaces(depsgraph, wanted):
    """Every surface with its place: (object, matrix). ``wanted`` selects the original objects."""
    for instance in depsgraph.object_instances:
        thing = instance.object
        owner = instance.parent if instance.is_instance else thing
        if thing.type in SURFACES and instance.show_self and wanted(thing.original, owner.original):
            yield thing, instance.matrix_world.copy()


def is_modelled(thing, owner):
    """Whether an object is in the photograph."""
    hidden = thing.hide_render or owner.hide_render
    return not (hidden or thing.get(INSERTED) or owner.get(INSERTED))


def meshes(depsgraph, wanted=is_modelled, ignored=frozenset()):
    """The meshes of the scene, and the materials by the names of their groups.

    Surfaces of the groups ``ignored`` are left out.
    """
    found, materials = [], {}
    for thing, matrix in surfaces(depsgraph, wanted):
        mesh = thing.to_mesh()
        if mesh is None:
            continue
        slots = [slot.material for slot in thing.material_slots] or list(mesh.materials)
        for material, part in parts(mesh, slots, np.array(matrix)):
            name = group_name(material)
            if name not in ignored:
                materials[name] = material
                found.append(unrender.Mesh(name, name=thing.original.name, **part))
        thing.to_mesh_clear()
    return found, materials


def parts(mesh, slots, matrix):
    """The parts of a mesh by material: (material, arrays)."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return
    corners = read(mesh.loop_triangles, "loops", (count, 3), np.int32)
    index = read(mesh.loop_triangles, "material_index", (count,), np.int32)
    vertex = read(mesh.loops, "vertex_index", (len(mesh.loops),), np.int32)
    positions = read(mesh.vertices, "co", (len(mesh.vertices), 3))
    normals = read(mesh.corner_normals, "vector", (len(mesh.loops), 3))
    uvs = texture_coordinates(mesh)
    linear = matrix[:3, :3]
    positions = y_up(positions @ linear.T + matrix[:3, 3])
    # Normals are transformed by the inverse transpose; mirrored triangles get the reverse order of
    # corners.
    normals = y_up(normals @ np.linalg.pinv(linear))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    if np.linalg.det(linear) < 0.0:
        corners = corners[:, ::-1]
    index = np.clip(index, 0, max(len(slots) - 1, 0))
    for number in np.unique(index):
        loops = corners[index == number]
        material = slots[number] if slots else None
        yield material, arrays(loops, vertex, positions, normals, uvs)


def arrays(loops, vertex, positions, normals, uvs):
    """Merges vertices with the same position, normal and texture coordinates."""
    columns = [positions[vertex[loops.ravel()]], normals[loops.ravel()]]
    if uvs is not None:
        columns.append(uvs[loops.ravel()])
    rows = np.ascontiguousarray(np.hstack(columns), dtype=np.float32)
    rows, where = np.unique(rows, axis=0, return_inverse=True)
    return {
        "vertices": rows[:, :3],
        "faces": where.reshape(-1, 3),
        "normals": rows[:, 3:6],
        "uvs": rows[:, 6:8] if uvs is not None else None,
    }


def texture_coordinates(mesh):
    """The texture coordinates that are rendered, from the top left of the texture; None if there
    are none."""
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    if layer is None:
        return None
    uvs = read(layer.uv, "vector", (len(mesh.loops), 2))
    return np.stack([uvs[:, 0], 1.0 - uvs[:, 1]], axis=1)


def read(items, name, shape, kind=np.float32):
    """The property ``name`` of all items."""
    values = np.empty(int(np.prod(shape)), dtype=kind)
    items.foreach_get(name, values)
    return values.reshape(shape)
