import { describe, expect, it } from "vitest";
import type { Clip, Document } from "../src/messages";
import {
  addReference,
  changeReference,
  referencesOf,
  removeReference,
  setCounterpart,
  setJoint,
  setReferenceFile,
  setReferenceRange,
} from "../src/references";
import { Store } from "../src/store";
import { frameRange, referenceNames, referenceSpan } from "../src/timeline/reference_span";
import { clipOf } from "./clips";
import { EMPTY } from "./empty";

const paths = (document: Document): (string | null)[] => document.references.map((one) => one.path);
const two = addReference(addReference(EMPTY, "limp.bvh"), "run.bvh");

describe("references", () => {
  it("are the clip itself where none is named", () => {
    expect(referencesOf(EMPTY).map((one) => one.path)).toEqual([null]);
    expect(addReference(EMPTY, null)).toEqual(EMPTY);
  });

  it("are added: the first file takes the place of the clip itself, which may be added again", () => {
    expect(paths(two)).toEqual(["limp.bvh", "run.bvh"]);
    expect(paths(addReference(two, null))).toEqual(["limp.bvh", "run.bvh", null]);
  });

  it("are removed, down to the clip itself", () => {
    expect(paths(removeReference(two, 0))).toEqual(["run.bvh"]);
    expect(removeReference(removeReference(two, 0), 0)).toEqual(EMPTY);
  });

  it("change one at a time", () => {
    const changed = changeReference(two, 1, { weight: 2, mirror: true });
    expect(changed.references.map((one) => [one.weight, one.mirror])).toEqual([
      [1, false],
      [2, true],
    ]);
    expect(two.references[1]?.weight).toBe(1);
  });

  it("that are the clip itself, with nothing said about it, are none", () => {
    const mirrored = changeReference(EMPTY, 0, { mirror: true });
    expect(mirrored.references).toHaveLength(1);
    expect(changeReference(mirrored, 0, { mirror: false })).toEqual(EMPTY);
    const cut = setReferenceRange(EMPTY, 0, { first: 10, last: 40 });
    expect(cut.references[0]).toMatchObject({ path: null, first_frame: 10, last_frame: 40 });
    expect(setReferenceRange(cut, 0, null)).toEqual(EMPTY);
    // Beside others it is one of them.
    expect(paths(setReferenceRange(addReference(two, null), 2, null))).toEqual(["limp.bvh", "run.bvh", null]);
  });

  it("forget frames and joints of a file that another one replaces, and keep weight and mirror", () => {
    const said = setJoint(
      setReferenceRange(changeReference(two, 0, { weight: 3, mirror: true }), 0, { first: 1, last: 9 }),
      0,
      "Hips",
      "root",
    );
    expect(setReferenceFile(said, 0, "hop.bvh").references[0]).toMatchObject({
      path: "hop.bvh",
      weight: 3,
      mirror: true,
      first_frame: null,
      joints: [],
    });
  });

  it("say of a joint once what stands for it", () => {
    const said = setJoint(setJoint(setJoint(two, 1, "Hips", "root"), 1, "Head", "skull"), 1, "Hips", "pelvis");
    expect(said.references[1]?.joints).toEqual([
      { input: "Head", reference: "skull" },
      { input: "Hips", reference: "pelvis" },
    ]);
    expect(setJoint(said, 1, "Head", null).references[1]?.joints).toEqual([{ input: "Hips", reference: "pelvis" }]);
  });

  it("have a counterpart for each clip of a group", () => {
    const both = setCounterpart(setCounterpart(two, 0, 2, "c.bvh"), 0, 1, "b.bvh");
    expect(both.references[0]?.counterparts.map((one) => [one.clip, one.path])).toEqual([
      [1, "b.bvh"],
      [2, "c.bvh"],
    ]);
    expect(setCounterpart(both, 0, 1, null).references[0]?.counterparts.map((one) => one.clip)).toEqual([2]);
  });
});

const clip = (change: Partial<Clip>): Clip => clipOf({ name: "walk", first_frame: 1, ...change });

describe("a reference in its own time", () => {
  // Frames 101 to 161 of a file that has 101 to 301, at 20 a second.
  const limp = clip({
    what: "reference",
    count: 2,
    name: "limp",
    rate: 20,
    n_frames: 61,
    first_frame: 101,
    n_whole: 201,
  });
  const store = new Store(() => undefined);
  store.setClip(clip({}));
  store.setClip(limp);
  store.setClip(clip({ what: "reference", index: 1, count: 2, start_time: 1, n_frames: 11, first_frame: 11 }));
  store.setDocument(
    setReferenceRange(addReference(addReference(EMPTY, "limp.bvh"), null), 0, { first: 101, last: 161 }),
  );
  store.setDocument(setReferenceRange(store.document as Document, 1, { first: 11, last: 21 }));

  it("is all of its file, and the range that the document says", () => {
    expect(referenceSpan(store)).toMatchObject({
      source: 0,
      lastTime: 10,
      start: 0,
      end: 3,
      offset: 0,
      firstFrame: 101,
    });
    store.look({ reference: 1 });
    expect(referenceSpan(store)).toMatchObject({ source: 1, lastTime: 4, start: 1, end: 2, offset: 1, firstFrame: 1 });
    // One that is gone gives way to the last there is.
    store.look({ reference: 7 });
    expect(store.reference).toBe(1);
  });

  it("goes with the hand before the clip comes", () => {
    const before = store.document as Document;
    store.setDocument(setReferenceRange(before, 1, { first: 16, last: 31 }));
    expect(referenceSpan(store, 1)).toMatchObject({ start: 1.5, end: 3, offset: 1 });
    store.setDocument(before);
  });

  it("is written as frames of its file, and all of them as none", () => {
    const span = referenceSpan(store, 0);
    if (!span) throw new Error("there is a span");
    expect(frameRange(span, 1, 2.5)).toEqual({ first: 121, last: 151 });
    expect(frameRange(span, 0, 10)).toBeNull();
  });

  it("is called by its name, and by its stretch where two have one name", () => {
    expect(referenceNames(store)).toEqual(["limp", "The clip itself"]);
    store.setDocument(addReference(store.document as Document, null));
    expect(referenceNames(store)).toEqual(["limp", "The clip itself, 1.0–2.0 s", "The clip itself (3)"]);
  });
});
