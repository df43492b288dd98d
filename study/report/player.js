// Plays skeletons side by side on one clock. No library, no request: all data stands in the page.
"use strict";
(() => {
  const PITCH = 0.16;
  const players = [];

  // The page's style says what is drawn in which colour, in a light and in a dark surrounding.
  const colors = {};
  function readColors() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["right", "left", "trunk", "aloft", "grid", "flight", "unit", "speed"])
      colors[name] = style.getPropertyValue(`--${name}`).trim();
  }

  function decode(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    const view = new DataView(bytes.buffer), values = new Int16Array(bytes.length / 2);
    for (let i = 0; i < values.length; i++) values[i] = view.getInt16(2 * i, true);
    return values;
  }

  function element(tag, attributes, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  }

  // Two ways to see a figure. Each returns where a place in metres is on the canvas, pixels a metre, and the middle.
  function beside(x0, z0, ground, yaw, w, h) {
    const size = Math.min(h / 2.4, w / 1.75), cos = Math.cos(yaw), sin = Math.sin(yaw);
    const tilt = Math.sin(PITCH), rise = Math.cos(PITCH);
    const project = (x, y, z) => [
      w / 2 + size * ((x - x0) * cos + (z - z0) * sin),
      h * 0.92 - size * ((y - ground) * rise - ((z - z0) * cos - (x - x0) * sin) * tilt),
    ];
    return [project, size, x0, z0];
  }

  function through([px, py, pz, ax, ay, az], w, h) {
    const far = Math.hypot(ax - px, ay - py, az - pz);
    const [fx, fy, fz] = [(ax - px) / far, (ay - py) / far, (az - pz) / far];
    const level = Math.hypot(fx, fz), [rx, rz] = [-fz / level, fx / level];
    const [ux, uy, uz] = [-rz * fy, rz * fx - rx * fz, rx * fy];
    const zoom = far * h / 2.7;
    const project = (x, y, z) => {
      const [dx, dy, dz] = [x - px, y - py, z - pz], depth = dx * fx + dy * fy + dz * fz;
      if (depth < 0.3) return null;
      return [w / 2 + zoom * (dx * rx + dz * rz) / depth, h / 2 - zoom * (dx * ux + dy * uy + dz * uz) / depth];
    };
    return [project, zoom / far, ax, az];
  }

  class View {
    constructor(data, shared) {
      this.data = data;
      this.shared = shared;
      this.poses = decode(data.poses);
      this.stage = element("canvas", {role: "img", "aria-label": `${data.label}: ${data.note}`});
      this.bar = element("canvas", {class: "bar", role: "img", "aria-label": `playback speed of ${data.label}`});
      this.state = element("p", {class: "state"});
      this.box = element("figure", {class: "view"},
        element("figcaption", {}, element("strong", {}, data.label), element("span", {}, data.note)),
        this.stage, ...(data.camera ? [] : [this.bar]), this.state);
      this.follow = this.smoothRoot();
      this.place = new Float64Array(shared.nodes * 3);
    }

    // The camera follows the root over the ground, and ignores its sway: a mean over a second.
    smoothRoot() {
      const {nodes, rate, grain} = this.shared, n = this.data.count, half = Math.round(rate / 2);
      const out = new Float64Array(2 * n);
      for (const [axis, offset] of [[0, 0], [1, 2]]) {
        const sums = new Float64Array(n + 1);
        for (let i = 0; i < n; i++) sums[i + 1] = sums[i] + this.poses[i * nodes * 3 + offset] * grain;
        for (let i = 0; i < n; i++) {
          const a = Math.max(0, i - half), b = Math.min(n, i + half + 1);
          out[2 * i + axis] = (sums[b] - sums[a]) / (b - a);
        }
      }
      return out;
    }

    fit() {
      const ratio = window.devicePixelRatio || 1;
      for (const canvas of this.box.querySelectorAll("canvas")) {
        const box = canvas.getBoundingClientRect();
        const width = Math.max(1, Math.round(box.width * ratio)), height = Math.max(1, Math.round(box.height * ratio));
        if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
      }
    }

    draw(time, yaw) {
      const {nodes, rate, grain, ground} = this.shared, data = this.data;
      const t = Math.min(Math.max(time, 0), data.seconds);
      let i = Math.min(Math.floor(t * rate), data.count - 1), share = 0;
      if (i < data.count - 1) {
        const end = i + 1 === data.count - 1 ? data.seconds : (i + 1) / rate;
        share = (t - i / rate) / (end - i / rate);
      }
      const next = Math.min(i + 1, data.count - 1), n = nodes * 3;
      for (let k = 0; k < n; k++) {
        const a = this.poses[i * n + k], b = this.poses[next * n + k];
        this.place[k] = (a + share * (b - a)) * grain;
      }
      const x0 = this.follow[2 * i] + share * (this.follow[2 * next] - this.follow[2 * i]);
      const z0 = this.follow[2 * i + 1] + share * (this.follow[2 * next + 1] - this.follow[2 * i + 1]);

      const canvas = this.stage, pen = canvas.getContext("2d"), w = canvas.width, h = canvas.height;
      const camera = data.camera && data.camera[i].map((value, k) => value + share * (data.camera[next][k] - value));
      const [project, size, mx, mz] = camera ? through(camera, w, h) : beside(x0, z0, ground, yaw, w, h);
      pen.clearRect(0, 0, w, h);

      // The ground: lines half a metre apart, so that one sees how far the figure goes.
      pen.strokeStyle = colors.grid;
      pen.lineWidth = h / 260;
      const reach = 2, gap = 0.5;
      pen.beginPath();
      const line = (x1, z1, x2, z2) => {
        const a = project(x1, ground, z1), b = project(x2, ground, z2);
        if (a && b) { pen.moveTo(...a); pen.lineTo(...b); }
      };
      for (let k = Math.ceil((mx - reach) / gap); k * gap <= mx + reach; k++)
        line(k * gap, mz - reach, k * gap, mz + reach);
      for (let k = Math.ceil((mz - reach) / gap); k * gap <= mz + reach; k++)
        line(mx - reach, k * gap, mx + reach, k * gap);
      pen.stroke();

      const aloft = data.aloft && data.aloft[i];
      pen.lineCap = pen.lineJoin = "round";
      for (const [side, line] of this.shared.chains) {
        pen.strokeStyle = side === "" && aloft ? colors.aloft : colors[side || "trunk"];
        pen.lineWidth = size * (side === "" ? 0.05 : 0.042);
        const places = line.map(node => project(...this.place.subarray(3 * node, 3 * node + 3)));
        if (places.includes(null)) continue;
        pen.beginPath();
        for (const place of places) pen.lineTo(...place);
        pen.stroke();
      }
      if (this.shared.head) {
        const [node, radius] = this.shared.head;
        const place = project(...this.place.subarray(3 * node, 3 * node + 3));
        pen.fillStyle = aloft ? colors.aloft : colors.trunk;
        pen.beginPath();
        if (place) pen.arc(...place, size * radius, 0, 2 * Math.PI);
        pen.fill();
      }
      if (camera) {
        // Where the camera looks.
        pen.strokeStyle = colors.aloft;
        pen.lineWidth = h / 200;
        pen.beginPath();
        for (const [dx, dy] of [[1, 0], [0, 1]]) {
          pen.moveTo(w / 2 - dx * h / 24, h / 2 - dy * h / 24);
          pen.lineTo(w / 2 + dx * h / 24, h / 2 + dy * h / 24);
        }
        pen.stroke();
      }

      const over = time > data.seconds + 1e-9;
      const speed = data.speeds ? `${data.speeds[i].toFixed(2)} ×` : data.camera ? "seen by the camera" : "its own time";
      this.state.textContent = `${t.toFixed(2)} s  ·  ${over ? "ended" : speed}${aloft && !over ? "  ·  in flight" : ""}`;
      canvas.style.opacity = over ? 0.45 : 1;
      if (!data.camera) this.drawBar(t);
    }

    // Playback speed over output time: a log scale from 1/10 to 10, unit speed in the middle, flights shaded.
    drawBar(t) {
      const canvas = this.bar, pen = canvas.getContext("2d"), w = canvas.width, h = canvas.height;
      const wide = w / this.shared.longest, data = this.data;
      pen.clearRect(0, 0, w, h);
      if (data.speeds) {
        pen.fillStyle = colors.flight;
        for (const [a, b] of data.flights) pen.fillRect(a * wide, 0, Math.max(1, (b - a) * wide), h);
        pen.strokeStyle = colors.unit;
        pen.lineWidth = 1;
        pen.beginPath();
        pen.moveTo(0, h / 2);
        pen.lineTo(data.seconds * wide, h / 2);
        pen.stroke();
        pen.strokeStyle = colors.speed;
        pen.lineWidth = h / 34;
        pen.beginPath();
        data.speeds.forEach((speed, i) => {
          const level = Math.log10(Math.min(10, Math.max(0.1, speed)));
          const y = h / 2 - level * (h / 2 - 2);
          const x = i / this.shared.rate * wide, end = Math.min((i + 1) / this.shared.rate, data.seconds) * wide;
          if (i) pen.lineTo(x, y); else pen.moveTo(x, y);
          pen.lineTo(end, y);
        });
        pen.stroke();
      }
      pen.fillStyle = colors.aloft;
      pen.fillRect(Math.min(t * wide, w - 2), 0, Math.max(2, w / 200), h);
    }
  }

  class Player {
    constructor(root) {
      const data = JSON.parse(root.querySelector("script").textContent);
      this.key = data.key;
      this.root = root;
      data.longest = Math.max(...data.versions.map(version => version.seconds));
      this.data = data;
      this.views = data.versions.map(version => new View(version, data));
      this.time = 0;
      // From the figure's right, a little to the front, so that it moves along with the page.
      this.yaw = data.heading;
      this.pace = 1;
      this.playing = false;
      this.visible = false;
      this.wanted = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;

      this.button = element("button", {type: "button"}, "Play");
      this.slider = element("input", {type: "range", min: 0, max: data.longest, step: 0.01, value: 0,
        "aria-label": "output time, seconds"});
      const pace = element("select", {"aria-label": "how fast to show it"});
      for (const [value, label] of [[0.25, "¼ speed"], [0.5, "½ speed"], [1, "true speed"]])
        pace.append(element("option", value === 1 ? {value, selected: ""} : {value}, label));
      this.clock = element("output", {});
      const views = element("div", {class: "views"}, ...this.views.map(view => view.box));
      const count = this.views.length;
      views.style.setProperty("--columns", count > 6 ? Math.ceil(count / 2) : count);
      root.append(views, element("div", {class: "controls"}, this.button, this.slider, this.clock, pace));

      this.button.addEventListener("click", () => { this.wanted = !this.playing; this.set(this.wanted); });
      this.slider.addEventListener("input", () => {
        this.wanted = false; this.set(false); this.time = Number(this.slider.value); this.draw();
      });
      pace.addEventListener("change", () => { this.pace = Number(pace.value); });
      let from = null;
      views.addEventListener("pointerdown", event => {
        if (event.target.tagName !== "CANVAS") return;
        from = [event.clientX, this.yaw];
        views.setPointerCapture(event.pointerId);
      });
      views.addEventListener("pointermove", event => {
        if (!from) return;
        this.yaw = from[1] + (event.clientX - from[0]) / 120;
        this.draw();
      });
      for (const end of ["pointerup", "pointercancel"]) views.addEventListener(end, () => { from = null; });
      new IntersectionObserver(entries => {
        this.visible = entries[entries.length - 1].isIntersecting;
        this.set(this.visible && this.wanted);
      }).observe(root);
      new ResizeObserver(() => this.draw()).observe(views);
    }

    set(playing) {
      if (playing && !this.playing) {
        this.last = null;
        requestAnimationFrame(now => this.tick(now));
      }
      this.playing = playing;
      this.button.textContent = playing ? "Pause" : "Play";
    }

    tick(now) {
      if (!this.playing) return;
      if (this.last !== null) {
        this.time += Math.min(0.1, (now - this.last) / 1000) * this.pace;
        // A moment's rest on the last pose.
        if (this.time > this.data.longest + 0.8) this.time = 0;
      }
      this.last = now;
      this.draw();
      requestAnimationFrame(later => this.tick(later));
    }

    hold(time) {
      this.wanted = false;
      this.set(false);
      this.time = time;
      this.draw();
    }

    draw() {
      for (const view of this.views) { view.fit(); view.draw(this.time, this.yaw); }
      this.slider.value = Math.min(this.time, this.data.longest);
      this.clock.textContent = `${Math.min(this.time, this.data.longest).toFixed(2)} s`;
    }
  }

  readColors();
  for (const root of document.querySelectorAll(".player")) players.push(new Player(root));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readColors();
    for (const player of players) player.draw();
  });

  // "#V4@3.2" shows V4 at 3.2 seconds, "#@3.2" every player: a moment can be linked to.
  function go() {
    const asked = /^#(\w*)@([\d.]+)$/.exec(decodeURIComponent(location.hash));
    if (!asked) return;
    for (const player of players) if (!asked[1] || player.key === asked[1]) player.hold(Number(asked[2]));
    const shown = asked[1] && players.find(player => player.key === asked[1]);
    const place = shown && shown.root.closest("section");
    if (place) place.scrollIntoView({behavior: "instant"});
  }
  window.addEventListener("hashchange", go);
  go();
})();
