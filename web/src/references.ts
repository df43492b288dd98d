/** Edits of a document's references: which clips it moves like, or which stretch of itself. */

import type { Document, ReferenceFile } from "./messages";

export const PLAIN_REFERENCE: ReferenceFile = {
  path: null,
  first_frame: null,
  last_frame: null,
  weight: 1,
  mirror: false,
  fps: null,
  skeleton: null,
  up: null,
  channels: null,
  gaps: null,
  root: null,
  joint_map: null,
  joints: [],
  counterparts: [],
};

/** The references as a person sees them: where a document names none, the clip itself is imitated. */
export function referencesOf(document: Document): readonly ReferenceFile[] {
  return document.references.length > 0 ? document.references : [PLAIN_REFERENCE];
}

/** Whether a reference is the whole clip itself with nothing else set; as the only one it is the same as none. */
function isBare({ path, first_frame, last_frame, mirror, joint_map, joints }: ReferenceFile): boolean {
  return (
    path === null && first_frame === null && last_frame === null && !mirror && joint_map === null && joints.length === 0
  );
}

function withReferences(document: Document, references: readonly ReferenceFile[]): Document {
  const [only] = references;
  return { ...document, references: references.length === 1 && only && isBare(only) ? [] : references };
}

/** Add a file as a reference, or where the path is null the clip itself. The first file replaces the clip itself. */
export function addReference(document: Document, path: string | null): Document {
  return withReferences(document, [...document.references, { ...PLAIN_REFERENCE, path }]);
}

export function changeReference(document: Document, index: number, change: Partial<ReferenceFile>): Document {
  return withReferences(
    document,
    referencesOf(document).map((one, i) => (i === index ? { ...one, ...change } : one)),
  );
}

export function removeReference(document: Document, index: number): Document {
  return withReferences(
    document,
    document.references.filter((_, i) => i !== index),
  );
}

/** Replace a reference by a file, or by the clip itself. The old one's frames and joints don't apply any more. */
export function setReferenceFile(document: Document, index: number, path: string | null): Document {
  const { weight, mirror } = referencesOf(document)[index] ?? PLAIN_REFERENCE;
  return changeReference(document, index, { ...PLAIN_REFERENCE, weight, mirror, path });
}

/** Say which frames of a reference are imitated, as its file numbers them; null: all of them. */
export function setReferenceRange(
  document: Document,
  index: number,
  range: { first: number; last: number } | null,
): Document {
  return changeReference(document, index, { first_frame: range?.first ?? null, last_frame: range?.last ?? null });
}

/** Say which joint of a reference stands for one of the clip's; null: as the names and the file say. */
export function setJoint(document: Document, index: number, input: string, reference: string | null): Document {
  const others = (referencesOf(document)[index]?.joints ?? []).filter((pair) => pair.input !== input);
  return changeReference(document, index, { joints: reference === null ? others : [...others, { input, reference }] });
}

/** Say what another searched clip of the group moves like; null: nothing. */
export function setCounterpart(document: Document, index: number, clip: number, path: string | null): Document {
  const others = (referencesOf(document)[index]?.counterparts ?? []).filter((one) => one.clip !== clip);
  const added =
    path === null ? [] : [{ clip, path, fps: null, skeleton: null, up: null, root: null, channels: null, gaps: null }];
  return changeReference(document, index, { counterparts: [...others, ...added].sort((a, b) => a.clip - b.clip) });
}
