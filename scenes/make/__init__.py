"""This package contains the modules of make_scenes.py: one module per scene, and shared helpers."""
