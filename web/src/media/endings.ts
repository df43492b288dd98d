/** Endings of what can stand beside the stage; a test compares them with what the server takes. */

export const MEDIA_ENDINGS: readonly string[] = [
  ".mp4",
  ".mov",
  ".m4v",
  ".mkv",
  ".webm",
  ".avi",
  ".ts",
  ".mts",
  ".m2ts",
  ".mpg",
  ".mpeg",
  ".mxf",
  ".3gp",
  ".ogv",
  ".wav",
  ".flac",
  ".opus",
  ".ogg",
  ".mp3",
  ".m4a",
  ".aac",
  ".mka",
  ".aiff",
  ".aif",
];

export function isMedia(path: string): boolean {
  return endsInOne(path, MEDIA_ENDINGS);
}

/** Of films that move and have no sound. */
export const ANIMATION_ENDINGS: readonly string[] = [".gif", ".webp", ".apng"];

export function isAnimation(path: string): boolean {
  return endsInOne(path, ANIMATION_ENDINGS);
}

function endsInOne(path: string, endings: readonly string[]): boolean {
  const lower = path.toLowerCase();
  return endings.some((ending) => lower.endsWith(ending));
}
