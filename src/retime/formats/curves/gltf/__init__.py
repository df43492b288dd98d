"""glTF 2.0: `format` is what the registry calls; `file` holds the document, `animation` its curves."""
