"""After Effects: a script that gives a layer Time Remap keys.

Keys of "ADBE Time Remapping" have a time of the composition and, as their value, a time of the layer's source, both in
seconds; time 0 is where the layer's own time begins (``startTime``). Time Remap has two keys of its own, which may go
only once there are others. Interpolation is set to linear on both sides of each key. It holds where two values are
equal, and runs backward.

Source: After Effects Scripting Guide, AVLayer.timeRemapEnabled, Property.setValuesAtTimes, removeKey,
setInterpolationTypeAtKey (https://ae-scripting.docsforadobe.dev/property/property/).
"""

from __future__ import annotations

import numpy as np

from retime.hosts.shot import Shot, plain_rows, warp_of
from retime.hosts.text import decoded, quoted, script_numbers
from retime.warp.curve import Warp

_AFTER = """
    var comp = app.project.activeItem, layer, remap, i, j, ours;
    if (!(comp instanceof CompItem)) { throw new Error("Open the composition first."); }
    layer = name === "" ? comp.selectedLayers[0] : comp.layers.byName(name);
    if (!layer) { throw new Error(name === "" ? "Select the layer first." : "There is no layer " + name + "."); }
    if (!layer.canSetTimeRemapEnabled) { throw new Error("This layer's source can't be remapped in time."); }
    app.beginUndoGroup("Retime");
    try {
        layer.timeRemapEnabled = true;
        remap = layer.property("ADBE Time Remapping");
        for (i = 0; i < at.length; i++) { at[i] += layer.startTime; }
        remap.setValuesAtTimes(at, shows);
        for (i = remap.numKeys; i >= 1; i--) {
            ours = false;
            for (j = 0; j < at.length && !ours; j++) { ours = Math.abs(remap.keyTime(i) - at[j]) < 1e-6; }
            if (!ours) { remap.removeKey(i); }
        }
        for (i = 1; i <= remap.numKeys; i++) {
            remap.setInterpolationTypeAtKey(i, KeyframeInterpolationType.LINEAR, KeyframeInterpolationType.LINEAR);
        }
        layer.outPoint = at[at.length - 1] + comp.frameDuration;
    } finally {
        app.endUndoGroup();
    }
})();
"""


def write(warp: Warp, shot: Shot) -> str:
    """Write the script, to be run by File > Scripts > Run Script File."""
    return (
        "// Retimes a layer: the selected one, or that of the name below. Edit > Undo takes it back.\n(function () {\n"
        f"    var name = {quoted(shot.item)};\n"
        f"    var at = [{', '.join(plain_rows(warp.output_times))}];\n"
        f"    var shows = [{', '.join(plain_rows(warp.input_times))}];"
        f"{_AFTER}"
    )


def read(data: bytes, shot: Shot) -> Warp:
    """Read the keys of a script that `write` made, to compare them."""
    text = decoded(data)
    return warp_of(np.array(script_numbers(text, "at")), np.array(script_numbers(text, "shows")))
