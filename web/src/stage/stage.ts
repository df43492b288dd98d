/** The stage: figures in space, seen by one camera, side by side or over each other. */

import * as THREE from "three";
import type { Clip } from "../messages";
import type { PlaybackState } from "../playback";
import { WhenQuiet } from "../quiet";
import { clamp } from "../scale";
import type { Store, Topic } from "../store";
import { figureColor, type Theme } from "../theme";
import { inputAt } from "../warp";
import { nearestMatch } from "../why";
import { showAround } from "./around";
import { StageCamera, travelOf } from "./camera";
import { CameraRig, cameraOf, eyeOf, isCamera } from "./cameras";
import { Cast, COMPANION, OUTPUT } from "./cast";
import { drawsInSoftware, makeRenderer } from "./gpu";
import { Ground } from "./ground";
import { SignalView } from "./signals";

/**
 * Drawn without a graphics card, a picture of the stage holds everything else up for tens of milliseconds. While
 * something is dragged, one is drawn when the hand has rested for some milliseconds, or after so many; and with fewer
 * pixels.
 */
const SLOW_REST = 100;
const SLOW_MOST = 3000;
const SLOW_RATIO = 0.5;

/** A moment, and how many pixels it is drawn in. */
interface Still {
  readonly moment: PlaybackState;
  readonly width: number;
  readonly height: number;
}

const TOPICS: readonly Topic[] = ["clips", "theme", "curve", "playhead", "view", "hover", "why", "size"];

export class Stage {
  private readonly renderer: THREE.WebGLRenderer | null;
  private readonly camera: StageCamera | null = null;
  /** Without a graphics card the processor draws, which has the curve to find meanwhile. */
  private readonly slow: boolean = drawsInSoftware();
  private readonly later = new WhenQuiet(() => this.renderer && this.draw(this.renderer), SLOW_REST, SLOW_MOST);
  private readonly scene = new THREE.Scene();
  private readonly signals: SignalView;
  private casts: Cast[] = [];
  private rigs: CameraRig[] = [];
  /** The input times that the two sides show. */
  private moments = { output: 0, companion: 0 };
  private ground: Ground | null = null;
  /** The clips that the casts were made of. */
  private shown: readonly Clip[] = [];
  private companionColor = "";
  private shape = "";
  private stale = true;

  constructor(
    private readonly root: HTMLElement,
    private readonly store: Store,
    private readonly theme: Theme,
  ) {
    this.renderer = makeRenderer(!this.slow);
    if (this.renderer) {
      const canvas = this.renderer.domElement;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", "Stage: the figures in space. Drag to turn, scroll to come closer.");
      root.prepend(canvas);
      this.camera = new StageCamera(
        canvas,
        () => this.turned(),
        () => store.view.navigation,
      );
      const sky = new THREE.HemisphereLight(0xffffff, 0x8a94a0, 2.1);
      const sun = new THREE.DirectionalLight(0xffffff, 1.6);
      sun.position.set(1, 2.5, 1.6);
      this.scene.add(sky, sun);
    }
    this.signals = new SignalView(root, store, theme);
  }

  /** Whether the browser can draw it. */
  get works(): boolean {
    return this.renderer !== null;
  }

  update(changed: Set<Topic>): void {
    const { clips, view } = this.store;
    // References come as clips too, and are none of the cast.
    const renewed =
      changed.has("clips") && (clips.length !== this.shown.length || clips.some((one, i) => one !== this.shown[i]));
    if (renewed || changed.has("theme")) {
      this.shown = clips;
      this.cast(renewed);
    }
    const clip = clips[view.clip] ?? this.store.clip;
    const isSignal = clip?.holds === "signal";
    this.signals.show(isSignal ? clip : null);
    if (this.renderer) this.renderer.domElement.style.visibility = isSignal ? "hidden" : "visible";
    if (isSignal || !this.renderer || this.casts.length === 0 || !this.store.knots) return;
    this.stale ||= TOPICS.some((topic) => changed.has(topic));
    // The pose of a keytime that is dragged is known before its curve.
    this.stale ||= this.store.draggedKey !== null && changed.has("document");
    if (!this.stale) return;
    if (this.slow && this.store.dragging) this.later.ask();
    else this.draw(this.renderer);
  }

  /** Look at all of the figures again, from where the camera stood at first. */
  frame(): void {
    if (!this.camera || this.casts.length === 0) return;
    const beside = new THREE.Box3();
    for (const rig of this.rigs) beside.union(rig.box);
    this.camera.frame(this.casts, this.store.view.follow, beside);
    this.turned();
  }

  private turned(): void {
    this.stale = true;
    this.store.viewMoved();
  }

  /** Put the figures of all clips on the stage, in the place of those before. */
  private cast(renewed: boolean): void {
    for (const one of [...this.casts, ...this.rigs]) one.dispose();
    this.rigs = [];
    this.ground?.dispose();
    this.ground = null;
    const { clips } = this.store;
    const { palette } = this.theme;
    this.companionColor = "";
    const figures = clips.filter((clip) => clip.holds === "motion" && clip.n_nodes > 0);
    // A camera is no figure, unless it is all there is.
    const isFigure = (clip: Clip): boolean => figures.includes(clip) && (!isCamera(clip) || figures.every(isCamera));
    this.casts = clips.flatMap((clip, i) => {
      const color = clips.length > 1 ? figureColor(clips, i) : null;
      return isFigure(clip) ? [new Cast(clip, this.scene, palette, color && palette[color])] : [];
    });
    const [first] = this.casts;
    if (!first) return;
    const colors = { companion: palette["figure-input"], output: palette.output };
    this.rigs = clips.filter(isCamera).map((clip) => new CameraRig(clip, this.scene, colors, 0.35 * first.height));
    const travel = travelOf(this.casts);
    const color = new THREE.Color(palette["stage-line"]);
    this.ground = new Ground({ low: travel.min, high: travel.max }, first.height, first.level, color);
    this.scene.add(this.ground.object);
    if (renewed) this.frame();
  }

  /**
   * Draw a moment in so many pixels, for a film; the picture has to be taken before anything else runs. Null where
   * there are no figures.
   */
  still(moment: PlaybackState, width: number, height: number): HTMLCanvasElement | null {
    if (!this.renderer || this.casts.length === 0) return null;
    this.stale = true;
    return this.draw(this.renderer, { moment, width, height }) ? this.renderer.domElement : null;
  }

  private draw(renderer: THREE.WebGLRenderer, film?: Still): boolean {
    this.stale = film !== undefined;
    this.later.cancel();
    if (!this.pose(film?.moment)) return false;
    const { store, root } = this;
    const { view } = store;
    const width = film?.width ?? Math.max(root.clientWidth, 1);
    const height = film?.height ?? Math.max(root.clientHeight, 1);
    this.fit(renderer, width, height, film && 1);
    const focus = this.casts.find((cast) => cast.clip === store.clips[view.clip]) ?? this.casts[0];
    const places = focus?.places();
    const half = view.layout === "side" ? width / 2 : width;
    const camera = view.through ? cameraOf(store.clips, view.clip) : null;
    const look = (left: number, layers: readonly number[], place: THREE.Vector3 | undefined): void => {
      const moment = layers.includes(OUTPUT) ? this.moments.output : this.moments.companion;
      const eye = camera
        ? eyeOf(camera, moment, half / height, layers)
        : this.camera?.eye(half / height, layers, view.follow ? place : undefined);
      if (!eye) return;
      renderer.setViewport(left, 0, half, height);
      renderer.setScissor(left, 0, half, height);
      renderer.render(this.scene, eye);
    };
    if (view.layout === "side") {
      look(0, [COMPANION], places?.companion);
      look(half, [OUTPUT], places?.output);
    } else look(0, [COMPANION, OUTPUT], places?.output);
    return true;
  }

  /** Give the canvas as many pixels as the stage has, or fewer where they cost too much. */
  private fit(renderer: THREE.WebGLRenderer, width: number, height: number, given?: number): void {
    const ratio = given ?? this.screenRatio;
    const shape = `${width} ${height} ${ratio}`;
    if (shape === this.shape) return;
    this.shape = shape;
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
    renderer.setScissorTest(true);
  }

  private get screenRatio(): number {
    return this.slow ? (this.store.dragging ? SLOW_RATIO : 1) : Math.min(devicePixelRatio, 2);
  }

  /** Put every figure into the pose that is looked at; whether there is one. */
  private pose(moment?: PlaybackState): boolean {
    const { store } = this;
    const { view, knots, companionKnots } = store;
    if (!knots) return false;
    const shown = view.showB && companionKnots ? companionKnots : knots;
    const other = view.showB && companionKnots ? knots : companionKnots;
    const looked = moment ? { ...moment, shown: null } : store.looked;
    const { outputTime } = looked;
    const outputInput = looked.shown ?? inputAt(shown, outputTime);
    const companionInput = other ? inputAt(other, outputTime) : looked.inputTime;
    const color = this.theme.palette[other ? "spline" : "figure-input"];
    for (const cast of this.casts) {
      if (this.companionColor !== color) cast.paintCompanion(color);
      cast.pose(outputInput, companionInput);
      cast.showSkin(view.mesh);
      cast.showShadows(view.ground);
      showAround(cast, knots, outputTime, store.rate, view);
      cast.showGhost(null, 0, false);
    }
    this.companionColor = color;
    this.moments = { output: outputInput, companion: companionInput };
    for (const rig of this.rigs) rig.pose(outputInput, companionInput, !view.through);
    if (!moment) this.showMatch(outputTime);
    if (this.ground) this.ground.object.visible = view.ground;
    return true;
  }

  /** While a frame is pointed at, or where that is asked for, lay the reference pose that it was matched with over the output's. */
  private showMatch(outputTime: number): void {
    const { store } = this;
    const isAsked = store.view.ghost || store.looked.by === "pointer";
    if (!isAsked || !store.why || store.dragging) return;
    const match = nearestMatch(store.why, outputTime);
    const first = this.casts.find((cast) => cast.clip === store.clip);
    if (!match || !first) return;
    if (match.source < 0) first.showGhost(store.clip, match.time, match.mirrored);
    else {
      const reference = store.references[match.source];
      if (!reference) return;
      const time = clamp(match.time, 0, (reference.n_frames - 1) / reference.rate);
      first.showGhost(reference, time, match.mirrored);
    }
  }
}
