"""The modules of make_scenes.py: one per scene, and shared helpers."""
