"""Converts Emberline's EXR channels to the passes of Blender's render layers."""
import hashlib

import numpy

# For each Blender pass: its name, channels and type, our channels, and the view layer's switch for the pass.
_PASSES = (
    ("Depth", "Z", "VALUE", ("Z",), "use_pass_z"),
    ("Position", "XYZ", "VECTOR", ("P.X", "-P.Z", "P.Y"), "use_pass_position"),
    ("Normal", "XYZ", "VECTOR", ("N.X", "-N.Z", "N.Y"), "use_pass_normal"),
    ("UV", "UVA", "VECTOR", ("UV.U", "UV.V", "A"), "use_pass_uv"),
    ("DiffCol", "RGB", "COLOR", ("albedo.R", "albedo.G", "albedo.B"), "use_pass_diffuse_color"),
)
_CRYPTOMATTES = (("Object", "object"), ("Material", "material"), ("Asset", "asset"))
NOISY, SAMPLES, ERROR = "Noisy Image", "Debug Sample Count", "Error"


def _cryptomattes(layer):
    return [(kind, ours) for kind, ours in _CRYPTOMATTES if getattr(layer, f"use_pass_cryptomatte_{ours}", False)]


def _levels(layer):
    return max(int(layer.pass_cryptomatte_depth) & ~1, 2)


def light_groups(layer):
    return [group.name for group in getattr(layer, "lightgroups", ())]


def requested_passes(scene, layer):
    """Returns (name, channels, type) of each pass of a view layer except Combined."""
    settings, own = scene.emberline, layer.emberline
    passes = [p[:3] for p in _PASSES if getattr(layer, p[4], False)]
    if settings.use_denoising:
        passes.append((NOISY, "RGBA", "COLOR"))
    if own.use_pass_samples:
        passes.append((SAMPLES, "X", "VALUE"))
    if own.use_pass_error:
        passes.append((ERROR, "X", "VALUE"))
    passes += [(f"Combined_{group}", "RGB", "COLOR") for group in light_groups(layer)]
    for kind, _ in _cryptomattes(layer):
        passes += [(f"Crypto{kind}{i:02}", "RGBA", "COLOR") for i in range((_levels(layer) + 1) // 2)]
    return passes


def options(scene, layer):
    """Returns the command's options that produce the requested passes."""
    names = {p[0] for p in requested_passes(scene, layer)}
    aovs = [channels[0].partition(".")[0] for name, _, _, channels, _ in _PASSES if name in names]
    if ERROR in names or scene.emberline.use_maps:
        aovs.append("variance")
    if scene.emberline.use_maps:
        aovs += ["time", "stop"]
    arguments = ["--aov", ",".join(aovs)] if aovs else []
    mattes = _cryptomattes(layer)
    if mattes:
        arguments += ["--cryptomatte", ",".join(ours for _, ours in mattes)]
        arguments += ["--cryptomatte-levels", str(_levels(layer))]
    if light_groups(layer):
        arguments += ["--light-groups"]
    return arguments


def _plane(planes, channel):
    if channel.startswith("-"):
        return -planes[channel[1:]]
    return planes[channel]


def fill(result_layer, name, channels):
    """Writes one plane per channel to a pass. A plane starts with the top row, a pass with the bottom row."""
    for rendered in result_layer.passes:
        if rendered.name == name:
            pixels = numpy.stack([c[::-1] for c in channels], axis=-1).astype(numpy.float32)
            pixels = pixels.reshape(-1, len(channels))
            try:
                rendered.rect.foreach_set(pixels.ravel())
            except (AttributeError, TypeError):
                rendered.rect = pixels  # Blender before 4
            return


def _layer_name(name):
    """Returns the name that --light-groups derives from `name`."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in name)


def put(result_layer, scene, layer, planes, groups):
    """Writes all passes of a finished frame. `groups` maps light layers, including "environment", to light groups."""
    shown = "denoised." if scene.emberline.use_denoising and "denoised.R" in planes else ""
    raw = [planes[c] for c in "RGBA"]
    fill(result_layer, "Combined", [planes[shown + c] for c in "RGB"] + [planes["A"]])
    names = {p[0] for p in requested_passes(scene, layer)}
    if NOISY in names:
        fill(result_layer, NOISY, raw)
    for name, _, _, channels, _ in _PASSES:
        if name in names:
            fill(result_layer, name, [_plane(planes, c) for c in channels])
    if SAMPLES in names:
        fill(result_layer, SAMPLES, [planes["samples"]])
    if ERROR in names:
        fill(result_layer, ERROR, [numpy.sqrt(sum(planes[f"variance.{c}"] for c in "RGB") / 3)])
    for group in light_groups(layer):
        sums = [numpy.zeros_like(raw[0]) for _ in "RGB"]
        for ours, theirs in groups.items():
            channel = f"{shown}light.{_layer_name(ours)}."
            if theirs == group and channel + "R" in planes:
                sums = [s + planes[channel + c] for s, c in zip(sums, "RGB")]
        fill(result_layer, f"Combined_{group}", sums)
    for name in names:
        if name.startswith("Crypto") and name + ".R" in planes:
            fill(result_layer, name, [planes[f"{name}.{c}"] for c in "RGBA"])


def store_cryptomatte_names(result, layer, texts):
    """Stores the Cryptomatte manifests where Blender's Cryptomatte node expects them."""
    for key, name in texts.items():
        if not key.startswith("cryptomatte/") or not key.endswith("/name"):
            continue
        full = f"{layer.name}.{name}"
        theirs = "cryptomatte/" + hashlib.sha1(full.encode()).hexdigest()[:7]
        result.stamp_data_add_field(f"{theirs}/name", full)
        for part in ("hash", "conversion", "manifest"):
            result.stamp_data_add_field(f"{theirs}/{part}", texts[f"{key[:-5]}/{part}"])
