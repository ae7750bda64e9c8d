"""Prepares materials for Blender's exporter, and adds what the exporter omits."""
import copy

from . import images, lights


def used_nodes(tree):
    """Yields the nodes on which the active output depends."""
    outputs = [n for n in tree.nodes if n.type in ("OUTPUT_MATERIAL", "OUTPUT_WORLD", "OUTPUT_LIGHT") and n.is_active_output]
    seen, waiting = set(), outputs
    while waiting:
        node = waiting.pop()
        if node.name in seen:
            continue
        seen.add(node.name)
        yield node
        waiting += [link.from_node for entry in node.inputs for link in entry.links]


def image_nodes(material):
    if not material.use_nodes or not material.node_tree:
        return []
    return [node for node in used_nodes(material.node_tree) if node.type == "TEX_IMAGE" and node.image]


class Copies:
    """Provides what the exporter requires: original materials, or copies of them. Animated materials are copied with
    this frame's values. Where the exporter would write different image values than Cycles reads, a copy has other
    images."""

    def __init__(self, depsgraph, ids, names):
        """Adds to `names` the name of each copy, mapped to the name of its original."""
        self._depsgraph, self._ids, self._copies = depsgraph, ids, {}
        self._substitutes = images.SubstituteImages(ids, depsgraph.scene.frame_current)
        self.names = names

    def of(self, material):
        if not material:
            return None
        original = material.original
        if original not in self._copies:
            tree = original.node_tree
            animated = original.animation_data or (tree and tree.animation_data)
            substitutes = {node.name: self._substitutes.of(node) for node in image_nodes(original)}
            substitutes = {name: found for name, found in substitutes.items() if found}
            self._copies[original] = self._copy(original, substitutes) if animated or substitutes else original
        return self._copies[original]

    def _copy(self, original, substitutes):
        copied = original.copy()
        self._ids.append(copied)
        self.names[copied.name] = original.name
        evaluated = original.evaluated_get(self._depsgraph)
        copied.animation_data_clear()
        if original.node_tree:
            copied.node_tree.animation_data_clear()
            for node in copied.node_tree.nodes:
                self._copy_values(node, evaluated.node_tree.nodes.get(node.name))
        for name, found in substitutes.items():
            images.apply_substitutes(copied.node_tree.nodes[name], found)
        return copied

    @staticmethod
    def _copy_values(node, evaluated):
        if not evaluated:
            return
        for to, of in (*zip(node.inputs, evaluated.inputs), *zip(node.outputs, evaluated.outputs)):
            if hasattr(to, "default_value"):
                to.default_value = of.default_value


def surface_node(material):
    """Returns the node that is connected to the material's active output, or None."""
    return lights.active_surface_node(material.node_tree, "OUTPUT_MATERIAL") if material.use_nodes else None


def restore_names(glb, names):
    for material in glb.json.get("materials", []):
        if material.get("name") in names:
            material["name"] = names[material["name"]]


def _plain(glb, material, colour, metallic, roughness, specular=1):
    material["pbrMetallicRoughness"] = {
        "baseColorFactor": [*colour, 1],
        "metallicFactor": metallic,
        "roughnessFactor": roughness,
    }
    if not specular:
        glb.use("KHR_materials_specular")
        material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0}


def _blend(material, node):
    """Turns on alpha blending wherever alpha is below 1, as in Cycles. Before Blender 4.2, the exporter itself follows
    EEVEE's settings instead."""
    alpha = node.inputs["Alpha"]
    source = alpha.links[0].from_node if alpha.is_linked else None
    plain = not source or source.type == "TEX_IMAGE"
    if source and plain and source.image and source.image.source == "FILE" and source.image.size[0]:
        if alpha.links[0].from_socket.name == "Alpha" and images.is_opaque(source.image):
            return
    if source or alpha.default_value < 1:
        if plain or "alphaMode" not in material:
            material["alphaMode"] = "BLEND"
            material.pop("alphaCutoff", None)


def complete(glb):
    """Adds to the file's materials what the exporter does not write."""
    import bpy

    for material in glb.json.get("materials", []):
        source = bpy.data.materials.get(material.get("name", ""))
        node = surface_node(source) if source else None
        extensions = material.setdefault("extensions", {})
        # In glTF, transmission without a volume means a thin sheet, but Cycles refracts.
        if extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0) > 0:
            volume = extensions.setdefault("KHR_materials_volume", {})
            volume.setdefault("thicknessFactor", 1.0)
            glb.use("KHR_materials_volume")
        if node and node.type == "BSDF_PRINCIPLED":
            _blend(material, node)
        if node and node.type == "EMISSION":
            _plain(glb, material, (0, 0, 0), 0, 1, specular=0)
        elif node and node.type == "BSDF_DIFFUSE" and not node.inputs["Color"].is_linked:
            _plain(glb, material, node.inputs["Color"].default_value[:3], 0, 1, specular=0)
        elif node and node.type == "BSDF_GLOSSY" and not any(node.inputs[i].is_linked for i in ("Color", "Roughness")):
            roughness = node.inputs["Roughness"].default_value
            _plain(glb, material, node.inputs["Color"].default_value[:3], 1, roughness)
        if not extensions:
            del material["extensions"]


class LightGroups:
    """Copies the emissive materials that objects in light groups use, once per group."""

    def __init__(self, glb):
        self._glb = glb
        self._emissive = {
            i
            for i, m in enumerate(glb.json.get("materials", []))
            if any(c > 0 for c in m.get("emissiveFactor", (0, 0, 0)))
        }
        self._materials, self._meshes = {}, {}
        self.layers = {}  # the light group of each layer name

    def mesh(self, index, group):
        mesh = self._glb.json["meshes"][index]
        shines = any(p.get("material") in self._emissive for p in mesh["primitives"])
        if not group or not shines:
            return index
        if (index, group) not in self._meshes:
            other = copy.deepcopy(mesh)
            for primitive in other["primitives"]:
                if primitive.get("material") in self._emissive:
                    primitive["material"] = self._material(primitive["material"], group)
            self._meshes[index, group] = self._glb.add("meshes", other)
        return self._meshes[index, group]

    def _material(self, index, group):
        if (index, group) not in self._materials:
            other = copy.deepcopy(self._glb.json["materials"][index])
            self._materials[index, group] = self._glb.add("materials", other)
        return self._materials[index, group]

    def name_emitters(self):
        """Gives each copy a unique name, so that its layer can be identified."""
        for (index, group), made in self._materials.items():
            material = self._glb.json["materials"][made]
            material["name"] = f"group{made}-{material.get('name', '')}"
            self.layers[material["name"]] = group
