"""Checks that the stub has exactly the names, members and parameters that the module has."""
import ast
import inspect
import re
import unittest
from pathlib import Path

import emberline

FOLDER = Path(emberline.__file__).parent
# Every class has special methods. Only these are compared, because ours may differ from the default.
PUBLIC_SPECIAL_METHODS = ("__init__", "__getitem__", "__setitem__", "__iter__", "__contains__", "__copy__", "__deepcopy__")


def is_public(name):
    return not name.startswith("_") or name == "__version__"


def parameters_of_stub(function):
    arguments = function.args
    names = [a.arg for a in arguments.args + arguments.kwonlyargs]
    return names + (["**" + arguments.kwarg.arg] if arguments.kwarg else [])


def parameters_of(function):
    """Returns the parameters from the first line of the docstring, where pybind11 writes the signature."""
    inside = re.match(r"\w+\((.*)\) ->", function.__doc__.splitlines()[0])[1]
    while re.search(r"\[[^\[\]]*\]", inside):
        inside = re.sub(r"\[[^\[\]]*\]", "", inside)
    names = [part.split(":")[0].split("=")[0].strip() for part in inside.split(",")]
    return [name for name in names if name not in ("", "*")]


class Stub(unittest.TestCase):
    def setUp(self):
        tree = ast.parse((FOLDER / "__init__.pyi").read_text())
        self.functions = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
        self.classes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}
        self.values = {n.target.id for n in tree.body if isinstance(n, ast.AnnAssign)}

    def test_is_installed_as_typed(self):
        self.assertTrue((FOLDER / "py.typed").exists())

    def test_names(self):
        stub = {*self.functions, *self.classes, *self.values}
        self.assertEqual({name for name in dir(emberline) if is_public(name)}, stub)
        self.assertGreater(len(stub), 12)

    def test_members(self):
        for name, node in self.classes.items():
            kind = getattr(emberline, name)
            if issubclass(kind, Exception):
                self.assertEqual([base.id for base in node.bases], [base.__name__ for base in kind.__bases__])
                continue
            members = {n.name: n for n in node.body if isinstance(n, ast.FunctionDef)}
            real = {m for m in vars(kind) if is_public(m) or (m in PUBLIC_SPECIAL_METHODS and not self.is_refused(kind, m))}
            self.assertEqual(real, set(members), name)
            for member, function in members.items():
                value = inspect.getattr_static(kind, member)
                is_property = any(getattr(d, "id", "") == "property" for d in function.decorator_list)
                self.assertEqual(isinstance(value, property), is_property, f"{name}.{member}")
                if not is_property:
                    said = parameters_of_stub(function)
                    self.assertEqual(parameters_of(getattr(kind, member)), said, f"{name}.{member}")

    def test_parameters(self):
        for name, function in self.functions.items():
            self.assertEqual(parameters_of(getattr(emberline, name)), parameters_of_stub(function), name)

    @staticmethod
    def is_refused(kind, member):
        """Returns whether only the module can create objects of this class."""
        return member == "__init__" and "_emberline" not in (vars(kind)[member].__doc__ or "")


if __name__ == "__main__":
    unittest.main()
