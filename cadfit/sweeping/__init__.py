"""Frames along a path, and the meshes swept along it."""
