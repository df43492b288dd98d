"""Formats whose animation is curves with keys (glTF, FBX, USD): retimed in place, nothing but the curves changed."""
