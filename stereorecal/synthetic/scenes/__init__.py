"""Scenes that can be rendered: one module for each kind."""
