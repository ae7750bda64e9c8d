"""Materials on their way through Blender's exporter: what it needs before, and what it leaves out."""
import copy


class Copies:
    """Originals for the exporter, which knows no others: animated materials as copies that have this frame's values."""

    def __init__(self, depsgraph, ids, names):
        """`names` gets those of copies, and the originals' with them."""
        self._depsgraph, self._ids, self._copies = depsgraph, ids, {}
        self.names = names

    def of(self, material):
        if not material:
            return None
        original = material.original
        tree = original.node_tree
        if not original.animation_data and not (tree and tree.animation_data):
            return original
        if original not in self._copies:
            self._copies[original] = copied = original.copy()
            self._ids.append(copied)
            self.names[copied.name] = original.name
            evaluated = original.evaluated_get(self._depsgraph)
            copied.animation_data_clear()
            if tree:
                copied.node_tree.animation_data_clear()
                for node in copied.node_tree.nodes:
                    self._take_values(node, evaluated.node_tree.nodes.get(node.name))
        return self._copies[original]

    @staticmethod
    def _take_values(node, evaluated):
        for to, of in zip(node.inputs, evaluated.inputs if evaluated else ()):
            if hasattr(to, "default_value"):
                to.default_value = of.default_value
        for to, of in zip(node.outputs, evaluated.outputs if evaluated else ()):
            if hasattr(to, "default_value"):
                to.default_value = of.default_value


def surface_node(material):
    """What the material's active output shows."""
    if not material.use_nodes or not material.node_tree:
        return None
    for node in material.node_tree.nodes:
        if node.type == "OUTPUT_MATERIAL" and node.is_active_output and node.inputs["Surface"].is_linked:
            return node.inputs["Surface"].links[0].from_node
    return None


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


def complete(glb):
    """Puts in what the exporter has no word for."""
    import bpy

    for material in glb.json.get("materials", []):
        source = bpy.data.materials.get(material.get("name", ""))
        node = surface_node(source) if source else None
        extensions = material.setdefault("extensions", {})
        # glTF's transmission without a volume is a thin sheet; Cycles refracts.
        if extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0) > 0:
            volume = extensions.setdefault("KHR_materials_volume", {})
            volume.setdefault("thicknessFactor", 1.0)
            glb.use("KHR_materials_volume")
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
    """Gives emissive materials that objects of different light groups wear a copy for each group."""

    def __init__(self, glb):
        self._glb = glb
        self._emissive = {
            i
            for i, m in enumerate(glb.json.get("materials", []))
            if any(c > 0 for c in m.get("emissiveFactor", (0, 0, 0)))
        }
        self._materials, self._meshes = {}, {}
        self.layers = {}  # name of a layer: light group

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
        """Names them so that their layers are known."""
        for (index, group), made in self._materials.items():
            material = self._glb.json["materials"][made]
            material["name"] = f"group{made}-{material.get('name', '')}"
            self.layers[material["name"]] = group
