/** The video beside the stage, and the sound: what belongs to the playhead, through the warp. */

import { make, setText } from "../dom";
import { fileName } from "../panels/top";
import { advance } from "../playback";
import type { Store, Topic } from "../store";
import { mediaTimeAt } from "./beside";
import { followed, type Step, stand, within } from "./follow";

/** Seconds of what comes that the speed is taken of. */
const AHEAD = 0.1;
const TOPICS: readonly Topic[] = ["document", "curve", "playhead", "hover", "view", "beside"];

export class MediaPanel {
  readonly root: HTMLElement;
  private readonly video = make("video", { playsinline: true, preload: "auto", tabindex: -1 });
  private readonly name = make("b");
  private readonly time = make("span");

  constructor(private readonly store: Store) {
    const { video } = this;
    this.root = make(
      "aside",
      { class: "media", "aria-label": "Video beside the stage", hidden: true },
      video,
      make("div", { class: "caption", "data-is": "media" }, this.name, " ", this.time),
    );
    // The picture's size, and where a player is that went somewhere.
    for (const event of ["loadedmetadata", "seeked"]) {
      video.addEventListener(event, () => this.update(new Set<Topic>(["playhead"])));
    }
    video.addEventListener("error", () => {
      if (video.getAttribute("src") === null) return;
      const name = fileName(store.document?.media?.path ?? "");
      const words = `This browser can't play ${name}: choose a file that it plays, such as WebM, MP4 or WAV.`;
      store.setBeside({ mediaTrouble: words });
    });
  }

  /** Show other media, or none. */
  show(address: string | null): void {
    if (address === null) {
      this.video.removeAttribute("src");
      this.video.load();
    } else this.video.src = address;
  }

  update(changed: Set<Topic>): void {
    if (!TOPICS.some((topic) => changed.has(topic))) return;
    const { store, video, root } = this;
    const { document, knots, rate } = store;
    const media = document?.media;
    const loaded = video.readyState >= HTMLMediaElement.HAVE_METADATA;
    const hasPicture = media != null && loaded && video.videoWidth > 0;
    if (root.hidden === hasPicture) root.hidden = !hasPicture;
    if (!media || !knots || !loaded) {
      video.pause();
      return;
    }
    video.muted = !store.view.heard;
    const wanted = mediaTimeAt(media, knots, rate, store.lookedAt);
    this.go(this.step(wanted));
    setText(this.name, fileName(media.path));
    setText(this.time, wanted < 0 || wanted > video.duration ? "is not running here" : `${wanted.toFixed(2)} s`);
  }

  private step(wanted: number): Step {
    const { store, video } = this;
    const { document, knots, playback, inputEnd, rate } = store;
    const media = document?.media;
    if (!media || !knots || playback.rate === 0) {
      return stand(video.currentTime, within(wanted, video.duration));
    }
    // As fast as they pass in a tenth of a second to come; at the very end, as in the tenth before.
    const ahead = advance({ ...playback, loop: false }, knots, inputEnd, AHEAD * Math.sign(playback.rate));
    const back = advance({ ...playback, loop: false }, knots, inputEnd, -AHEAD * Math.sign(playback.rate));
    const [from, to] =
      ahead.rate === 0 ? [back.outputTime, playback.outputTime] : [playback.outputTime, ahead.outputTime];
    const passed = mediaTimeAt(media, knots, rate, to) - mediaTimeAt(media, knots, rate, from);
    return followed(video.currentTime, wanted, passed / AHEAD, video.duration);
  }

  private go({ speed, seek }: Step): void {
    const { video } = this;
    // One place after the other: the next one is looked up when this one is there.
    if (seek !== null && !video.seeking) video.currentTime = seek;
    if (speed === null) {
      if (!video.paused) video.pause();
      return;
    }
    if (Math.abs(video.playbackRate - speed) > 0.01 * speed) video.playbackRate = speed;
    if (!video.paused) return;
    video.play().catch(() => {
      // A browser that lets no page make a sound before its person has touched it plays in silence.
      video.muted = true;
      void video.play().catch(() => undefined);
    });
  }
}
