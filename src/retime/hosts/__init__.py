"""A warp as the retime curve of another program: written for it, and read from it.

One module a host says what that program's numbers mean, and where that is written down. `registry` lists them,
`exporting` and `importing` are what people call.
"""
