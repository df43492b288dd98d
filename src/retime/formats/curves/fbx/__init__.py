"""FBX 7, binary and in text: `format` is what the registry calls; `file` holds the records, `scene` the objects."""
