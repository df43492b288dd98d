/** The stage: figures in space, seen by one camera, side by side or over each other. */

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Clip } from "../messages";
import { WhenQuiet } from "../quiet";
import { clamp } from "../scale";
import type { Store, Topic } from "../store";
import { figureColor, type Theme } from "../theme";
import { at, inputAt, outputEnd, outputStart } from "../warp";
import { nearestMatch } from "../why";
import { Cast, COMPANION, OUTPUT } from "./cast";
import { Ground } from "./ground";
import { SignalView } from "./signals";

/**
 * Drawn without a GPU, a picture of the stage holds everything else up for tens of milliseconds. While something is
 * dragged, one is drawn when the hand has rested for some milliseconds, or after so many; and with fewer pixels.
 */
const SLOW_REST = 100;
const SLOW_MOST = 3000;
const SLOW_RATIO = 0.5;

/** Seconds of output to each side of the playhead that trails and onion skins cover, and between onion skins. */
const AROUND = 1.2;
const ONION_STEP = 0.2;

export class Stage {
  private readonly renderer: THREE.WebGLRenderer | null;
  /** Without a graphics card the processor draws, which has the curve to find meanwhile. */
  private readonly slow: boolean = drawsInSoftware();
  private readonly later = new WhenQuiet(() => this.renderer && this.draw(this.renderer), SLOW_REST, SLOW_MOST);
  private shape = "";
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 1000);
  private readonly controls: OrbitControls | null = null;
  private readonly signals: SignalView;
  private casts: Cast[] = [];
  private shown: readonly Clip[] = [];
  private ground: Ground | null = null;
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
      this.controls = new OrbitControls(this.camera, canvas);
      this.controls.enableDamping = false;
      this.controls.addEventListener("change", () => {
        this.stale = true;
        store.touch("view");
      });
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
    const { clips } = this.store;
    // References come as clips too, and are none of the cast.
    const renewed =
      changed.has("clips") && (clips.length !== this.shown.length || clips.some((one, i) => one !== this.shown[i]));
    if (renewed || changed.has("theme")) {
      this.shown = [...clips];
      this.cast(renewed);
    }
    const clip = this.store.clips[this.store.view.clip] ?? this.store.clip;
    const isSignal = clip?.holds === "signal";
    this.signals.show(isSignal ? clip : null);
    if (this.renderer) this.renderer.domElement.style.visibility = isSignal ? "hidden" : "visible";
    if (isSignal || !this.renderer || this.casts.length === 0 || !this.store.knots) return;
    for (const topic of ["clips", "theme", "curve", "playhead", "view", "hover", "why", "size"] as const) {
      if (changed.has(topic)) this.stale = true;
    }
    if (!this.stale) return;
    if (this.slow && this.store.dragging) this.later.ask();
    else this.draw(this.renderer);
  }

  /** Look at all of the figures again, from where the camera stood at first. */
  frame(): void {
    const [first] = this.casts;
    if (!first || !this.controls) return;
    const { follow } = this.store.view;
    const travel = this.travel();
    const centre = travel.getCenter(new THREE.Vector3());
    const start = rootAt(first, 0);
    const way = rootAt(first, first.clip.n_frames - 1).sub(start);
    // Who walks away is seen from the side, and a little from ahead.
    const angle = way.length() > first.height ? Math.atan2(way.x, way.z) + (Math.PI / 180) * 62 : (Math.PI / 180) * 35;
    const size = follow ? first.height : Math.max(first.height, 0.42 * travel.getSize(new THREE.Vector3()).length());
    const target = follow ? new THREE.Vector3(0, 0, 0) : new THREE.Vector3(centre.x, 0, centre.z);
    target.y = first.level + 0.5 * first.height;
    this.controls.target.copy(target);
    const distance = 2.5 * size;
    this.camera.position.set(
      target.x + distance * Math.sin(angle) * 0.97,
      target.y + 0.3 * distance,
      target.z + distance * Math.cos(angle) * 0.97,
    );
    this.camera.near = 0.02 * size;
    this.camera.far = 60 * size + travel.getSize(new THREE.Vector3()).length();
    this.controls.minDistance = 0.4 * size;
    this.controls.maxDistance = 24 * size;
    this.controls.update();
    this.stale = true;
    this.store.touch("view");
  }

  private cast(renewed: boolean): void {
    for (const cast of this.casts) cast.dispose();
    this.ground?.dispose();
    this.ground = null;
    const { clips } = this.store;
    const { palette } = this.theme;
    this.companionColor = "";
    this.casts = clips.flatMap((clip, i) => {
      const color = clips.length > 1 ? figureColor(clips, i) : null;
      return clip.holds === "motion" && clip.n_nodes > 0
        ? [new Cast(clip, this.scene, palette, color && palette[color])]
        : [];
    });
    const [first] = this.casts;
    if (!first) return;
    const travel = this.travel();
    const color = new THREE.Color(this.theme.palette["stage-line"]);
    this.ground = new Ground({ low: travel.min, high: travel.max }, first.height, first.level, color);
    this.scene.add(this.ground.object);
    if (renewed) this.frame();
  }

  private travel(): THREE.Box3 {
    const box = new THREE.Box3();
    for (const cast of this.casts) {
      const every = Math.max(1, Math.floor(cast.clip.n_frames / 200));
      for (let frame = 0; frame < cast.clip.n_frames; frame += every) box.expandByPoint(rootAt(cast, frame));
    }
    return box;
  }

  private draw(renderer: THREE.WebGLRenderer): void {
    this.stale = false;
    this.later.cancel();
    const { store } = this;
    const { view, playback, knots, companionKnots } = store;
    if (!knots) return;
    const shown = view.showB && companionKnots ? companionKnots : knots;
    const other = view.showB && companionKnots ? knots : companionKnots;
    const outputTime = store.lookedAt;
    const outputInput = inputAt(shown, outputTime);
    const companionInput = other ? inputAt(other, outputTime) : playback.inputTime;
    const color = this.theme.palette[other ? "spline" : "figure-input"];
    for (const cast of this.casts) {
      if (this.companionColor !== color) cast.paintCompanion(color);
      cast.pose(outputInput, companionInput);
      cast.showShadows(view.ground);
      this.showWay(cast, outputTime);
      cast.showGhost(null, 0, false);
    }
    this.companionColor = color;
    this.showMatch(outputTime);
    if (this.ground) this.ground.object.visible = view.ground;

    const width = Math.max(this.root.clientWidth, 1);
    const height = Math.max(this.root.clientHeight, 1);
    const ratio = this.slow ? (store.dragging ? SLOW_RATIO : 1) : Math.min(devicePixelRatio, 2);
    const shape = `${width} ${height} ${ratio}`;
    if (shape !== this.shape) {
      this.shape = shape;
      renderer.setPixelRatio(ratio);
      renderer.setSize(width, height, false);
      renderer.setScissorTest(true);
    }
    const focus = this.casts.find((cast) => cast.clip === store.clips[view.clip]) ?? this.casts[0];
    const places = focus?.places();
    const half = view.layout === "side" ? width / 2 : width;
    const look = (left: number, layers: readonly number[], follow: THREE.Vector3 | undefined): void => {
      const eye = this.camera.clone();
      eye.aspect = half / height;
      if (view.follow && follow) eye.position.add(follow);
      eye.layers.set(0);
      for (const layer of layers) eye.layers.enable(layer);
      eye.updateProjectionMatrix();
      eye.updateMatrixWorld();
      renderer.setViewport(left, 0, half, height);
      renderer.setScissor(left, 0, half, height);
      renderer.render(this.scene, eye);
    };
    if (view.layout === "side") {
      look(0, [COMPANION], places?.companion);
      look(half, [OUTPUT], places?.output);
    } else look(0, [COMPANION, OUTPUT], places?.output);
  }

  private companionColor = "";

  private showWay(cast: Cast, outputTime: number): void {
    const { knots, view, rate } = this.store;
    cast.trails.object.visible = view.trails;
    cast.onion.object.visible = view.onion;
    if (!knots) return;
    const around = (step: number): { times: number[]; nearness: number[] } => {
      const low = Math.max(outputStart(knots), outputTime - AROUND);
      const high = Math.min(outputEnd(knots), outputTime + AROUND);
      const times: number[] = [];
      const nearness: number[] = [];
      for (let i = Math.ceil(low / step - 1e-6); i <= Math.floor(high / step + 1e-6); i++) {
        times.push(inputAt(knots, i * step));
        nearness.push(0.9 * (1 - Math.abs(i * step - outputTime) / AROUND) ** 0.7 || 0);
      }
      return { times, nearness };
    };
    if (view.trails) {
      // Faster clips would put their dots on top of each other.
      const { times, nearness } = around(Math.max(1 / rate, 1 / 30));
      cast.trails.show(times, nearness);
    }
    if (view.onion) {
      const { times, nearness } = around(ONION_STEP);
      cast.onion.show(
        times,
        nearness.map((near) => 0.75 * near),
      );
    }
  }

  /** While a frame is looked at, lay the reference pose that it was matched with over the output's. */
  private showMatch(outputTime: number): void {
    const { store } = this;
    if (store.hover === null || !store.why || store.dragging) return;
    const match = nearestMatch(store.why, outputTime);
    const first = this.casts.find((cast) => cast.clip === store.clip);
    if (!match || !first) return;
    if (match.source < 0) first.showGhost(store.clip, match.time, match.mirrored);
    else {
      const reference = store.references[match.source];
      if (reference)
        first.showGhost(reference, clamp(match.time, 0, (reference.n_frames - 1) / reference.rate), match.mirrored);
    }
  }
}

function rootAt(cast: Cast, frame: number): THREE.Vector3 {
  const i = frame * cast.clip.n_nodes * 3;
  return new THREE.Vector3(at(cast.clip.positions, i), cast.level, at(cast.clip.positions, i + 2));
}

function drawsInSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = context && names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/iu.test(String(name));
}

function makeRenderer(antialias: boolean): THREE.WebGLRenderer | null {
  try {
    return new THREE.WebGLRenderer({ antialias, alpha: true, powerPreference: "low-power" });
  } catch {
    // Without WebGL there is no stage; the timeline works all the same, and the page says so.
    return null;
  }
}
