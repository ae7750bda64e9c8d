"""Finds changes to materials and lights that a session accepts as edits, without a new scene (session/PROTOCOL.md)."""
from . import lights, materials

# For each node type, the sockets whose values the exporter or materials.py copies unchanged to factors in the file.
_FACTORS = {
    "BSDF_PRINCIPLED": {"Base Color": "base_color", "Metallic": "metallic", "Roughness": "roughness"},
    "BSDF_DIFFUSE": {"Color": "base_color"},
    "BSDF_GLOSSY": {"Color": "base_color", "Roughness": "roughness"},
}
_LIGHT = ("type", "shape", "size", "size_y", "angle", "shadow_soft_size", "spot_size", "spot_blend", "normalize")


def _plain(value):
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def material_state(material):
    """Returns (what edits cannot change, editable factors) of a material, or None if other nodes contribute to it."""
    surface = materials.surface_node(material)
    if not surface or surface.type not in _FACTORS or any(entry.is_linked for entry in surface.inputs):
        return None
    factors, edit, rest = _FACTORS[surface.type], {}, [surface.type, getattr(surface, "distribution", "")]
    for entry in surface.inputs:
        value = _plain(getattr(entry, "default_value", None))
        if entry.name in factors:
            edit[factors[entry.name]] = list(value[:3]) if isinstance(value, tuple) else value
        else:
            rest.append((entry.name, value))
    if any(c < 0 or c > 1 for c in edit["base_color"]):
        return None
    rest += [material.blend_method, material.alpha_threshold, material.use_backface_culling]
    return rest, edit


def light_state(light):
    """Returns (what edits cannot change, colour times power) of a light."""
    rest = [_plain(getattr(light, name, None)) for name in _LIGHT]
    return rest, [c * light.energy for c in lights.colour(light)]


def light_edit(before, now):
    """Returns the edit that changes a light's colour from `before` to `now`, or None if no edit can do that."""
    if any(b <= 0 < n for b, n in zip(before, now)):
        return None
    factors = [n / b if b > 0 else 0.0 for b, n in zip(before, now)]
    peak = max(factors)
    if peak <= 0:
        return {"on": False}
    return {"intensity": peak, "color": [f / peak for f in factors]} if peak < 1e9 else None
