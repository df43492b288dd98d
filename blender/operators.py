"""The buttons. All work is done by `execute`; with a window the search runs beside Blender, and Esc ends it."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import bpy

from retime.errors import OptionError, RetimeError, words_of

from . import editor
from .animated import selected_frames
from .asked import Way, fault_of
from .job import Job, Stopped, prepare, use_drawn

Result = set[str]


def selection(context: Any) -> list[Any]:
    """Return what is selected, and in pose mode what is posed; where that is nothing, the active object."""
    posed = list(context.objects_in_mode) if context.mode == "POSE" else []
    found = list(dict.fromkeys([*posed, *context.selected_objects]))
    return found or ([context.object] if context.object else [])


def show(settings: Any, lines: Sequence[str]) -> None:
    """Put what is to be said into the panel, and take errors away."""
    settings.summary = "\n".join(lines)
    settings.fault = settings.fault_field = ""
    settings.fault_item = -1


def blame(operator: Any, settings: Any, error: Exception, asked: Any = None) -> Result:
    """Put an error beside its field, and into Blender's status bar."""
    fault = fault_of(error, asked)
    text = fault.text if isinstance(error, RetimeError) else words_of(error)
    settings.fault, settings.fault_field, settings.fault_item = text, fault.field, fault.item
    operator.report({"ERROR"}, text)
    return {"CANCELLED"}


class _Searching:
    """An operator that searches: by `execute` at once, by `invoke` beside Blender."""

    way: Way = "RETIME"
    only_show = False
    _job: Job | None = None
    _thread: threading.Thread | None = None
    _timer: Any = None
    # Blender's own.
    report: Any

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.scene is not None

    def execute(self, context: Any) -> Result:
        return self._guarded(context, lambda: self._prepare(context), self._search_and_finish)

    def _prepare(self, context: Any) -> Job:
        return prepare(bpy.data, context.scene, selection(context), context.scene.retime, self.way)

    def _search_and_finish(self, context: Any) -> None:
        assert self._job is not None
        self._job.search()
        self._finish(context)

    def _finish(self, context: Any) -> None:
        assert self._job is not None
        job, scene = self._job, context.scene
        lines = job.preview(scene) if self.only_show else job.finish(bpy.data, scene)
        show(context.scene.retime, lines)
        self.report({"INFO"}, lines[0])

    def _guarded(self, context: Any, make: Callable[[], Job] | None, then: Callable[[Any], Any]) -> Result:
        """Do the work; what it refuses is shown beside its field."""
        settings = context.scene.retime
        if make is not None:
            self._job = None
        try:
            if make is not None:
                self._job = make()
            then(context)
        except Stopped:
            self.report({"INFO"}, "Stopped; nothing was changed")
            return {"CANCELLED"}
        except (RetimeError, OSError) as error:
            return blame(self, settings, error, None if self._job is None else self._job.asked)
        return {"FINISHED"}

    def invoke(self, context: Any, event: Any) -> Result:
        if bpy.app.background or context.window is None:
            return self.execute(context)
        begun = self._guarded(context, lambda: self._prepare(context), lambda context: None)
        if begun != {"FINISHED"}:
            return begun
        assert self._job is not None
        self._thread = threading.Thread(target=self._job.search, daemon=True)
        self._thread.start()
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> Result:
        assert self._job is not None
        assert self._thread is not None
        if event.type == "ESC":
            self._job.stop()
        if event.type == "TIMER" and self._thread.is_alive():
            share = round(100 * self._job.share)
            context.window_manager.progress_update(share)
            context.workspace.status_text_set(f"Retime: searching, {share} %. Esc stops it")
        if self._thread.is_alive():
            # Nothing may change under the search.
            return {"RUNNING_MODAL"}
        self._tidy(context)
        return self._guarded(context, None, self._finish)

    def cancel(self, context: Any) -> None:
        """End the search with the window; Blender calls this, when another file is opened too."""
        assert self._job is not None
        self._job.stop()
        self._tidy(context)

    def _tidy(self, context: Any) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)


class RETIME_OT_retime(_Searching, bpy.types.Operator):
    """Find natural timing for the selection, and give it to all that it plays."""

    bl_idname = "retime.retime"
    bl_label = "Retime"
    bl_options = {"REGISTER", "UNDO"}


class RETIME_OT_preview(_Searching, bpy.types.Operator):
    """Find the timing, and only show it: as keys of the scene's retime_curve in the graph editor."""

    bl_idname = "retime.preview"
    bl_label = "Preview"
    bl_options = {"REGISTER", "UNDO"}
    only_show = True


class RETIME_OT_propagate(_Searching, bpy.types.Operator):
    """A part was retimed by hand: carry its timing over to all of the motion."""

    bl_idname = "retime.propagate"
    bl_label = "Propagate"
    bl_options = {"REGISTER", "UNDO"}
    way = "PROPAGATE"


class RETIME_OT_synchronise(_Searching, bpy.types.Operator):
    """Keep the selection in step with the reference, which does the same things in the same order."""

    bl_idname = "retime.synchronise"
    bl_label = "Synchronise"
    bl_options = {"REGISTER", "UNDO"}
    way = "SYNCHRONISE"


class _Plain:
    """An operator that is done at once."""

    bl_options = {"REGISTER", "UNDO"}
    work: Callable[[Any, Any], None]

    def execute(self, context: Any) -> Result:
        settings = context.scene.retime
        try:
            self.work(context, settings)
        except (RetimeError, OSError) as error:
            return blame(self, settings, error)
        return {"FINISHED"}


class RETIME_OT_use_curve(_Plain, bpy.types.Operator):
    """Give the selection the timing of the retime_curve, as you drew it."""

    bl_idname = "retime.use_curve"
    bl_label = "Use the Curve"

    def work(self, context: Any, settings: Any) -> None:
        show(settings, use_drawn(bpy.data, context.scene, selection(context), settings))


class RETIME_OT_add_keytime(_Plain, bpy.types.Operator):
    """Add a keytime at the current frame; then change the frame that its pose shall be at."""

    bl_idname = "retime.add_keytime"
    bl_label = "Add at Current Frame"

    def work(self, context: Any, settings: Any) -> None:
        _add_keytimes(settings, {context.scene.frame_current_final: ""})


class RETIME_OT_keytimes_from_markers(_Plain, bpy.types.Operator):
    """Add a keytime for each selected timeline marker; for all of them where none is selected."""

    bl_idname = "retime.keytimes_from_markers"
    bl_label = "From Markers"

    def work(self, context: Any, settings: Any) -> None:
        markers = list(context.scene.timeline_markers)
        if not markers:
            raise OptionError("the scene has no timeline markers: press M in the timeline to set one", option="keys")
        chosen = [marker for marker in markers if marker.select] or markers
        _add_keytimes(settings, {float(marker.frame): marker.name for marker in chosen})


class RETIME_OT_keytimes_to_markers(_Plain, bpy.types.Operator):
    """Move each keytime that was made of a marker to where this marker is now."""

    bl_idname = "retime.keytimes_to_markers"
    bl_label = "To Moved Markers"

    def work(self, context: Any, settings: Any) -> None:
        places = {marker.name: marker.frame for marker in context.scene.timeline_markers}
        made = [key for key in settings.keys if key.marker in places]
        if not made:
            raise OptionError("no keytime was made of a marker that is still there", option="keys")
        for key in made:
            key.to = places[key.marker]


class RETIME_OT_keytimes_from_keys(_Plain, bpy.types.Operator):
    """Add a keytime for each frame at which a key of the selection is selected."""

    bl_idname = "retime.keytimes_from_keys"
    bl_label = "From Selected Keys"

    def work(self, context: Any, settings: Any) -> None:
        frames = {frame: "" for one in selection(context) for frame in selected_frames(one)}
        if not frames:
            raise OptionError("no key of what is selected is selected in the dope sheet", option="keys")
        _add_keytimes(settings, frames)


def _add_keytimes(settings: Any, frames: dict[float, str]) -> None:
    known = [key.frame for key in settings.keys]
    for frame in sorted(frames):
        if not any(abs(frame - other) < 0.01 for other in known):
            key = settings.keys.add()
            key.frame = key.to = frame
            key.marker = frames[frame]


class RETIME_OT_remove_keytime(_Plain, bpy.types.Operator):
    """Remove this keytime; all of them from the button above."""

    bl_idname = "retime.remove_keytime"
    bl_label = "Remove Keytimes"
    __annotations__ = {"index": bpy.props.IntProperty(default=-1, options={"HIDDEN"})}

    def work(self, context: Any, settings: Any) -> None:
        _remove(settings.keys, self.index)


class RETIME_OT_add_lock(_Plain, bpy.types.Operator):
    """Lock a stretch to its own speed: the preview range, where that is on; else the selected keys."""

    bl_idname = "retime.add_lock"
    bl_label = "Lock a Range"

    def work(self, context: Any, settings: Any) -> None:
        scene = context.scene
        lock = settings.locks.add()
        if scene.use_preview_range:
            lock.start, lock.end = scene.frame_preview_start, scene.frame_preview_end
            return
        frames = [frame for one in selection(context) for frame in selected_frames(one)]
        now = scene.frame_current_final
        lock.start, lock.end = (min(frames), max(frames)) if frames and min(frames) < max(frames) else (now, now + 10)


class RETIME_OT_remove_lock(_Plain, bpy.types.Operator):
    """Remove this lock: the stretch may play at any speed again."""

    bl_idname = "retime.remove_lock"
    bl_label = "Remove Lock"
    __annotations__ = {"index": bpy.props.IntProperty(default=-1, options={"HIDDEN"})}

    def work(self, context: Any, settings: Any) -> None:
        _remove(settings.locks, self.index)


def _remove(collection: Any, index: int) -> None:
    if index < 0:
        collection.clear()
    elif index < len(collection):
        collection.remove(index)


class RETIME_OT_open_editor(_Plain, bpy.types.Operator):
    """Open the clip in retime's own editor, in your browser: needs an installed retime (pip install "retime[edit]")."""

    bl_idname = "retime.open_editor"
    bl_label = "Open in the Editor"

    def work(self, context: Any, settings: Any) -> None:
        command = context.preferences.addons[__package__].preferences.command or shutil.which("retime")
        if not command:
            raise OptionError(
                "found no retime command: install it with pip install 'retime[edit]', or name it in the preferences of "
                "this extension",
                option="editor",
            )
        job = prepare(bpy.data, context.scene, selection(context), settings, "RETIME")
        folder = Path(bpy.utils.extension_path_user(__package__, path="editor", create=True))
        project = editor.write_project(job.asked, folder, settings.root)
        editor.launch(command, project)
        settings.project = str(project)
        show(settings, ["Opened in the editor. Save it there (Ctrl S), then take the timing back"])


class RETIME_OT_take_from_editor(_Plain, bpy.types.Operator):
    """Give the selection the timing of the project as it was saved in the editor."""

    bl_idname = "retime.take_from_editor"
    bl_label = "Take the Timing Back"

    def work(self, context: Any, settings: Any) -> None:
        if not settings.project:
            raise OptionError("open the clip in the editor first, or choose a project", option="project")
        place = Path(bpy.path.abspath(settings.project))
        show(settings, editor.take_back(bpy.data, context.scene, selection(context), settings, place))


class RetimePreferences(bpy.types.AddonPreferences):
    """Preferences of the extension."""

    bl_idname = __package__
    __annotations__ = {
        "command": bpy.props.StringProperty(
            name="retime command",
            description="The program that opens the editor; empty: the one that the system finds",
            subtype="FILE_PATH",
        )
    }

    def draw(self, context: Any) -> None:
        """Draw them."""
        self.layout.prop(self, "command")


CLASSES = (
    RetimePreferences,
    RETIME_OT_retime,
    RETIME_OT_preview,
    RETIME_OT_propagate,
    RETIME_OT_synchronise,
    RETIME_OT_use_curve,
    RETIME_OT_add_keytime,
    RETIME_OT_keytimes_from_markers,
    RETIME_OT_keytimes_to_markers,
    RETIME_OT_keytimes_from_keys,
    RETIME_OT_remove_keytime,
    RETIME_OT_add_lock,
    RETIME_OT_remove_lock,
    RETIME_OT_open_editor,
    RETIME_OT_take_from_editor,
)


def register() -> None:
    """Add the buttons."""
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister() -> None:
    """Take them away again."""
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
