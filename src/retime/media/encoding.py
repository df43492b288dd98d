"""How the output is encoded: as the input was, where its container can hold that, unless told."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import FormatError, OptionError
from retime.media.extras import needed
from retime.media.options import MediaOptions

# FFmpeg's names of formats, by endings.
CONTAINERS = {
    ".mp4": "mp4", ".m4v": "mp4", ".mov": "mov", ".mkv": "matroska", ".webm": "webm", ".avi": "avi", ".ts": "mpegts",
    ".mts": "mpegts", ".m2ts": "mpegts", ".mpg": "vob", ".mpeg": "vob", ".mxf": "mxf", ".3gp": "3gp", ".ogv": "ogg",
    ".gif": "gif", ".webp": "webp", ".apng": "apng", ".wav": "wav", ".flac": "flac", ".opus": "opus", ".ogg": "ogg",
    ".mp3": "mp3", ".m4a": "ipod", ".aac": "adts", ".mka": "matroska", ".aiff": "aiff", ".aif": "aiff",
}  # fmt: skip

# The encoder of a codec, and those that make pictures.
_ENCODERS = {
    "h264": "libx264", "hevc": "libx265", "vp9": "libvpx-vp9", "vp8": "libvpx", "av1": "libsvtav1",
    "prores": "prores_ks", "opus": "libopus", "mp3": "libmp3lame", "vorbis": "libopus", "webp": "libwebp_anim",
}  # fmt: skip
_PICTURES = {
    ".png": "png", ".jpg": "mjpeg", ".jpeg": "mjpeg", ".tif": "tiff", ".tiff": "tiff", ".exr": "exr", ".dpx": "dpx",
    ".bmp": "bmp", ".webp": "libwebp",
}  # fmt: skip
_ONLY = {
    "gif": "gif",
    "webp": "libwebp_anim",
    "apng": "apng",
    "ogg": "libopus",
    "opus": "libopus",
}
# Where FFmpeg doesn't say all that a container holds, or says more.
_HOLDS = {
    "webm": {"vp8", "vp9", "av1", "opus", "vorbis"},
    "mpegts": {"h264", "hevc", "mpeg2video", "mpeg4", "aac", "ac3", "eac3", "mp2", "mp3", "opus"},
    # A program stream of MPEG-2, as cameras and DVDs have it.
    "vob": {"mpeg1video", "mpeg2video", "mp2", "mp3", "ac3"},
    # No place for how much an encoder adds before the first sample, so that compressed sound would be late.
    "avi": {"h264", "mpeg4", "mpeg2video", "mjpeg", "ffv1", "rawvideo", "huffyuv", "pcm_s16le", "pcm_u8"},
    "mxf": {"mpeg2video", "prores", "dnxhd", "pcm_s16le", "pcm_s24le"},
    # What programs expect in there: plain samples.
    "wav": {"pcm_u8", "pcm_s16le", "pcm_s24le", "pcm_s32le", "pcm_f32le", "pcm_f64le", "pcm_alaw", "pcm_mulaw"},
    "aiff": {"pcm_s8", "pcm_s16be", "pcm_s24be", "pcm_s32be", "pcm_f32be", "pcm_f64be"},
}
# And what few players find in there, though the format may hold it.
_UNUSUAL = {"mp4": {"pcm_s16le", "pcm_s16be", "pcm_s24le", "pcm_s24be", "pcm_s32le", "pcm_f32le", "pcm_f64le"}}
# Encoders that have a number for their quality, and what it is called.
_CRF = {"libx264": "crf", "libx265": "crf", "libvpx-vp9": "crf", "libvpx": "crf", "libsvtav1": "crf"}
_MOST_CRF = {"libx264": 51, "libx265": 51}
# These have no bytes a second: they keep everything, or have a quality of their own.
_WITHOUT_RATE = {
    "ffv1",
    "prores_ks",
    "qtrle",
    "png",
    "rawvideo",
    "huffyuv",
    "ffvhuff",
    "utvideo",
    "gif",
    "apng",
    "dnxhd",
}
# Kinds of codecs, by FFmpeg's names of the input's.
_PROFILES = {
    "prores_ks": {"Proxy": "proxy", "LT": "lt", "Standard": "standard", "HQ": "hq", "4444": "4444", "XQ": "4444xq"},
    "dnxhd": {
        "DNXHR LB": "dnxhr_lb",
        "DNXHR SQ": "dnxhr_sq",
        "DNXHR HQ": "dnxhr_hq",
        "DNXHR HQX": "dnxhr_hqx",
        "DNXHR 444": "dnxhr_444",
    },
}
_DNXHR_FORMATS = {
    "dnxhr_lb": ("yuv422p",),
    "dnxhr_sq": ("yuv422p",),
    "dnxhr_hq": ("yuv422p",),
    "dnxhr_hqx": ("yuv422p10le",),
    "dnxhr_444": ("yuv444p10le", "gbrp10le"),
}
# Encoders list these formats, and then refuse them.
_REFUSED = {
    "libvpx-vp9": {"yuva422p", "yuva444p", "gbrap"},
    "libx265": {"yuva420p", "yuva420p10le"},
    "ffv1": {"yaf16le", "yaf32le", "grayf16le", "grayf32le", "gbrpf16le", "gbrpf32le", "gbrapf16le", "gbrapf32le"},
}
# Their files say no range: players take them for narrow.
_NO_RANGE = {"mpeg1video", "mpeg2video", "mpeg4", "prores_ks", "dnxhd"}
# The same in all but a name: full range, which is told beside.
_FULL_RANGE = {"yuvj420p": "yuv420p", "yuvj422p": "yuv422p", "yuvj444p": "yuv444p"}


def encoder_for_pictures(place: Path) -> str:
    """Return the encoder of numbered pictures by their ending."""
    return _PICTURES[place.suffix.lower()]


def encoder_for(kind: str, codec: str | None, container: Any, told: str | None, place: Path) -> str:
    """Choose an encoder.

    Parameters
    ----------
    kind : {"video", "audio"}
        Of what.
    codec : str, optional
        The input's.
    container : OutputContainer
        What it goes into.
    told : str, optional
        What the user wants.
    place : Path
        For messages.

    Raises
    ------
    OptionError
        There is no such encoder, or the container can't hold what it makes.
    FormatError
        The container holds nothing of the kind.
    """
    av = needed("av")
    name = container.format.name
    holds = set(_HOLDS.get(name, container.supported_codecs))
    if told is None:
        holds -= _UNUSUAL.get(name, set())
    if told is not None:
        encoder = _ENCODERS.get(told, told)
        try:
            found = av.Codec(encoder, "w")
        except (av.codec.codec.UnknownCodecError, ValueError):
            raise OptionError(f"there is no encoder {told!r}; h264, hevc, vp9, av1, prores and ffv1 are some") from None
        if found.type != kind:
            raise OptionError(f"{told!r} encodes {found.type}, not {kind}")
        if found.canonical_name not in holds:
            raise OptionError(f"{place.suffix} can't hold {told}; .mkv and .mov hold most")
        return encoder
    usual = container.default_video_codec if kind == "video" else container.default_audio_codec
    if name in _ONLY and (kind == "audio") == (_ONLY[name] == "libopus"):
        return _ONLY[name]
    if name == "webm":
        usual = "opus" if kind == "audio" else "vp9"
    elif name == "matroska" and kind == "audio":
        usual = "aac"
    elif name == "avi" and kind == "audio":
        usual = "pcm_s16le"
    elif name in ("mpegts", "3gp"):
        usual = "aac" if kind == "audio" else "h264"
    if not usual or usual == "none":
        raise FormatError(f"a {place.suffix} file holds no {kind}", path=place)
    for wanted in (codec, usual):
        encoder = _ENCODERS.get(wanted or "", wanted or "")
        try:
            if av.Codec(encoder, "w").canonical_name in holds:
                return encoder
        except (av.codec.codec.UnknownCodecError, ValueError):
            continue
    raise FormatError(f"nothing here encodes {codec or usual} for a {place.suffix} file", path=place)


def is_grey(form: Any) -> bool:
    """Say whether a pixel format holds light alone (and alpha)."""
    return not form.has_palette and len([1 for one in form.components if not one.is_alpha]) == 1


def is_rgb(form: Any) -> bool:
    """Say whether a pixel format holds red, green and blue, as they are or in a palette."""
    return bool(form.is_rgb or form.has_palette)


def range_of(frame: Any) -> int:
    """Return a frame's range as FFmpeg numbers it: 2 (full), or 1 (narrow), which is meant where nothing is told."""
    if is_rgb(frame.format) or frame.format.name in _FULL_RANGE:
        return 2
    return int(frame.color_range) or 1


def pixel_format_for(encoder: str, source: str, told: str | None) -> str:
    """Choose the pixel format: the source's, or what loses the least of it.

    Raises
    ------
    OptionError
        The encoder doesn't take the one that the user wants.
    """
    av = needed("av")
    refused = _REFUSED.get(encoder, set())
    takes: list[str] = [one.name for one in av.Codec(encoder, "w").video_formats or [] if one.name not in refused]
    if told is not None:
        if takes and told not in takes:
            raise OptionError(f"{encoder} takes {', '.join(takes)}; not {told}")
        return told
    if not takes or source in takes:
        return source
    if _FULL_RANGE.get(source) in takes:
        return _FULL_RANGE[source]
    if encoder == "gif":
        return "pal8"
    return min(takes, key=lambda name: _loss(source, name))


def _loss(source: str, name: str) -> tuple[float, ...]:
    """Say how much of one format another loses: colour, alpha, depth, sharpness of colour; then how much it wastes."""
    av = needed("av")
    a, b = av.VideoFormat(source, 64, 64), av.VideoFormat(name, 64, 64)

    def alpha(form: Any) -> bool:
        return bool(form.has_palette or any(component.is_alpha for component in form.components))

    def depth(form: Any) -> int:
        return 8 if form.has_palette else max((component.bits for component in form.components), default=8)

    def chroma(form: Any) -> float:
        if form.has_palette or form.is_rgb or is_grey(form):
            return 1.0
        return float(form.chroma_width() * form.chroma_height() / 64**2)

    return (
        float(is_grey(b) and not is_grey(a)),
        float(b.has_palette and not a.has_palette),
        float(alpha(a) and not alpha(b)),
        max(0, depth(a) - depth(b)),
        max(0.0, chroma(a) - chroma(b)),
        float(bool(a.is_rgb or a.has_palette) != bool(b.is_rgb)),
        float(alpha(b) and not alpha(a)),
        depth(b) - depth(a),
        chroma(b),
    )


def add_video(
    container: Any,
    source: Any,
    frame: Any,
    beside: Any,
    aspect: Fraction | None,
    rate: Fraction,
    base: Fraction,
    bytes_a_second: float | None,
    options: MediaOptions,
    place: Path,
) -> Any:
    """Add a stream to a container, which has what the input's has: colours, shape of pixels, rotation, names.

    Parameters
    ----------
    container : OutputContainer
        Of PyAV.
    source : VideoStream, optional
        Of the input.
    frame : VideoFrame
        The first that will be shown.
    beside : VideoFrame
        The same as it was decoded, with what lies beside its picture: light and, where it stays as it lies, how it is
        to be turned.
    aspect : Fraction, optional
        Width of a pixel, over its height.
    rate, base : Fraction
        Frames a second, and seconds a tick of their stamps.
    bytes_a_second : float, optional
        Of the input.
    options : MediaOptions
        What the user wants.
    place : Path
        For messages.
    """
    context = None if source is None else source.codec_context
    codec = None if context is None else context.codec.canonical_name
    encoder = encoder_for("video", codec, container, options.codec, place)
    form = pixel_format_for(encoder, frame.format.name, options.pixel_format)
    wanted = {"x265-params": "log-level=none"} if encoder == "libx265" else {}
    if encoder.startswith("libvpx") and form.startswith("yuva"):
        # Frames that are never shown have no alpha.
        wanted["auto-alt-ref"] = "0"
    if encoder == "libx264" and container.format.name == "avi":
        # AVI has no place for when a frame is shown that is not shown in the order of decoding.
        wanted["bf"] = "0"
    stream = container.add_stream(encoder, rate=rate, options=wanted)
    made = stream.codec_context
    made.time_base = base
    made.width, made.height, made.pix_fmt = frame.width, frame.height, form
    made.thread_count = 0
    set_quality(made, stream, encoder, bytes_a_second, options, wanted)
    if encoder in _PROFILES:
        set_profile(encoder, "" if context is None or context.profile is None else context.profile, form, wanted)
    copy_looks(context, frame, beside, made, stream, encoder, wanted)
    if aspect is not None:
        made.sample_aspect_ratio = aspect
    if source is not None:
        keep_names(source, stream)
    made.options = {**made.options, **wanted}
    return stream


def set_quality(
    made: Any,
    stream: Any,
    encoder: str,
    bytes_a_second: float | None,
    options: MediaOptions,
    wanted: dict[str, str],
) -> None:
    """Say how good the encoder is to be: as asked for, or by the bytes a second that the input has."""
    if encoder == "libvpx-vp9":
        wanted |= {"deadline": "good", "cpu-used": "4", "row-mt": "1"}
    if encoder == "ffv1":
        wanted |= {"level": "3", "slices": "4"}
    if encoder in ("libwebp", "libwebp_anim"):
        wanted |= {"lossless": "0", "quality": str(90 if options.quality is None else max(1, 100 - options.quality))}
    elif options.quality is not None:
        if encoder in _CRF:
            wanted[_CRF[encoder]] = str(min(options.quality, _MOST_CRF.get(encoder, 63)))
            if encoder.startswith("libvpx"):
                wanted["b"] = "0"
        elif encoder not in _WITHOUT_RATE:
            # Quantisers of MPEG: from 1 to 31.
            made.qmin = made.qmax = max(1, min(31, options.quality // 2))
    elif encoder not in _WITHOUT_RATE and bytes_a_second:
        made.bit_rate = max(20_000, int(8 * bytes_a_second))
    elif encoder in _CRF:
        wanted[_CRF[encoder]] = "18" if encoder in _MOST_CRF else "28"
    if encoder == "mjpeg":
        made.qmin = made.qmax = 2 if options.quality is None else max(1, min(31, options.quality // 2))


def set_profile(encoder: str, source: str, form: str, wanted: dict[str, str]) -> None:
    """Choose among the kinds of a codec that editing programs use: the input's, or the best for the pixel format."""
    av = needed("av")
    known = _PROFILES[encoder].get(source)
    if known is not None and (encoder != "dnxhd" or form in _DNXHR_FORMATS[known]):
        wanted["profile"] = known
    elif encoder == "dnxhd":
        # Other kinds of it are for some sizes and rates alone.
        wanted["profile"] = next(
            (name for name, takes in reversed(_DNXHR_FORMATS.items()) if form in takes), "dnxhr_hq"
        )
    if encoder == "prores_ks" and any(one.is_alpha for one in av.VideoFormat(form, 16, 16).components):
        # Of the two kinds with alpha none is smaller than this.
        wanted["profile"] = wanted.get("profile", "4444") if wanted.get("profile") == "4444xq" else "4444"


def keep_names(source: Any, stream: Any) -> None:
    """Give a stream what the input's says of its part: language, title, whether it is the usual one or a comment."""
    stream.metadata.update({key: value for key, value in source.metadata.items() if key in ("language", "title")})
    stream.disposition = source.disposition


def copy_looks(
    context: Any, frame: Any, beside: Any, made: Any, stream: Any, encoder: str, wanted: dict[str, str]
) -> None:
    """Say what the samples mean, as the input says it: range, matrix, primaries, curve, light, rotation."""
    for name in ("color_range", "color_primaries", "color_trc", "colorspace"):
        said = getattr(frame, name)
        # 2 is "not said"; of the range 0 is.
        if said in (0, 2) and name != "color_range" and context is not None:
            said = getattr(context, name)
        setattr(made, name, int(said))
    form = needed("av").VideoFormat(made.pix_fmt, 16, 16)
    if form.is_rgb or form.has_palette:
        made.colorspace, made.color_range = 0, 2
    elif is_grey(form):
        made.colorspace = 2
    elif made.colorspace == 0:
        # Pictures of red, green and blue, or of grey, made luma and chroma: by the matrix and the range that are meant
        # where none is said (BT.601, narrow), since AVI and MPEG say neither.
        made.colorspace, made.color_range = 6, 2 if made.pix_fmt in _FULL_RANGE else 1
    elif encoder in _NO_RANGE:
        made.color_range = 1
    matrix = side_data(frame, "DISPLAYMATRIX")
    if matrix is not None:
        stream.set_display_matrix([int(number) for number in np.frombuffer(matrix, np.int32)[:9]])
    light = light_parameters(beside)
    if light and encoder == "libx265":
        wanted["x265-params"] = ":".join([wanted["x265-params"], "hdr10=1", *light])
    elif light and encoder == "libx264":
        wanted["x264-params"] = ":".join(
            one.replace("master-display", "mastering-display").replace("max-cll", "cll") for one in light
        )
    elif light and encoder == "libsvtav1":
        wanted["svtav1-params"] = ":".join(
            _in_parts(one).replace("master-display", "mastering-display").replace("max-cll", "content-light")
            for one in light
        )


def _in_parts(light: str) -> str:
    """Write places of colours and of light as SVT-AV1 reads them: as parts of 1, and in candelas."""

    def written(match: re.Match[str]) -> str:
        unit = 10_000 if match[1] == "L" else 50_000
        return f"{match[1]}({int(match[2]) / unit:g},{int(match[3]) / unit:g})"

    return re.sub(r"(G|B|R|WP|L)\((\d+),(\d+)\)", written, light)


def side_data(frame: Any, name: str) -> bytes | None:
    """Return what a frame carries beside its picture."""
    av = needed("av")
    for one in frame.side_data:
        if one.type == av.sidedata.sidedata.Type[name]:
            return bytes(one)
    return None


def light_parameters(frame: Any) -> list[str]:
    """Return how light a picture of high range is, and the screen that it was made on, as x264 and x265 read it."""
    found = []
    screen = side_data(frame, "MASTERING_DISPLAY_METADATA")
    if screen is not None and len(screen) >= 88:
        numbers = np.frombuffer(screen[:80], np.int32).astype(np.float64).reshape(10, 2)
        has_colours, has_light = np.frombuffer(screen[80:88], np.int32)
        if has_colours and has_light and (numbers[:, 1] > 0).all():
            red, green, blue, white = (numbers[:8, 0] / numbers[:8, 1]).reshape(4, 2)
            low, high = numbers[8:, 0] / numbers[8:, 1]
            places = [
                f"{letter}({round(x * 50000)},{round(y * 50000)})"
                for letter, (x, y) in (("G", green), ("B", blue), ("R", red), ("WP", white))
            ]
            found.append(f"master-display={''.join(places)}L({round(high * 10000)},{round(low * 10000)})")
    level = side_data(frame, "CONTENT_LIGHT_LEVEL")
    if level is not None and len(level) >= 8:
        most, mean = np.frombuffer(level[:8], np.uint32)
        found.append(f"max-cll={most},{mean}")
    return found
