"use strict";
// The view that is turned by hand: the skin of the body, the crack's lip and its fronts, by WebGL 2 alone.
(() => {
  const VERTEX = `#version 300 es
    in vec3 place; in vec3 colour;
    uniform mat3 turn; uniform vec3 middle, aside; uniform vec2 scale; uniform float depth;
    out vec3 at; out vec3 shade;
    void main() {
      at = place; shade = colour;
      vec3 seen = turn * (place - middle);
      gl_Position = vec4(seen.xy * scale, -seen.z * depth, 1.0) + vec4(aside, 0.0);
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    in vec3 at; in vec3 shade;
    uniform mat3 turn; uniform float clear, flatly;
    out vec4 result;
    void main() {
      vec3 facing = turn * normalize(cross(dFdx(at), dFdy(at)));
      float light = mix(0.55 + 0.45 * abs(dot(facing, normalize(vec3(0.35, 0.5, 0.8)))), 1.0, flatly);
      result = vec4(shade * light, clear);
    }`;
  // matplotlib's tab20, and steps of its viridis
  const GRAINS = ["1f77b4", "aec7e8", "ff7f0e", "ffbb78", "2ca02c", "98df8a", "d62728", "ff9896", "9467bd", "c5b0d5",
    "8c564b", "c49c94", "e377c2", "f7b6d2", "7f7f7f", "c7c7c7", "bcbd22", "dbdb8d", "17becf", "9edae5"].map(rgb);
  const SIZES = ["440154", "482475", "414487", "355f8d", "2a788e", "21918c", "22a884", "44bf70", "7ad151", "bddf26",
    "fde725"].map(rgb);
  const LIP = rgb("e8d9b5"), FRONT = rgb("dc143c");

  function rgb(hex) {
    return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
  }

  function numbers(text, kind) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return new kind(bytes.buffer);
  }

  function places(text, box) {
    return Float32Array.from(numbers(text, Uint16Array), (value, k) =>
      box[0][k % 3] + (value / 65535) * (box[1][k % 3] - box[0][k % 3]));
  }

  function bySize(share) {
    const place = Math.min(Math.max(share, 0), 1) * (SIZES.length - 1), low = Math.min(Math.floor(place), SIZES.length - 2);
    return SIZES[low].map((value, k) => value + (place - low) * (SIZES[low + 1][k] - value));
  }

  // Corners and colours of triangles, none shared; `limits` is what the colours of all lengths go over.
  function triangles(part, box, own, limits, colour) {
    const at = places(part.points, box), corner = numbers(part.triangles, Uint32Array);
    const grain = numbers(part.grain, Uint32Array), length = numbers(part.length, Uint16Array);
    const place = new Float32Array(3 * corner.length), shade = new Float32Array(3 * corner.length);
    corner.forEach((node, k) => {
      const size = own[0] + (length[node] / 65535) * (own[1] - own[0]);
      const tint = colour === "length" ? bySize((size - limits[0]) / (limits[1] - limits[0] || 1))
        : grain[Math.floor(k / 3)] ? GRAINS[grain[Math.floor(k / 3)] % 20] : LIP;
      for (let i = 0; i < 3; i++) {
        place[3 * k + i] = at[3 * node + i];
        shade[3 * k + i] = tint[i];
      }
    });
    return { place, shade };
  }

  function lines(fronts, box) {
    const place = fronts.flatMap((text) => {
      const at = places(text, box), ends = [];
      for (let k = 3; k < at.length; k += 3) ends.push(...at.slice(k - 3, k + 3));
      return ends;
    });
    return { place: Float32Array.from(place), shade: Float32Array.from(place, (_, k) => FRONT[k % 3]) };
  }

  function program(gl) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    gl.useProgram(made);
    return made;
  }

  function upload(gl, made, part) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const [name, values] of [["place", part.place], ["colour", part.shade]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      const slot = gl.getAttribLocation(made, name);
      gl.enableVertexAttribArray(slot);
      gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 0, 0);
    }
    return { array, count: part.place.length / 3 };
  }

  function start(view) {
    const canvas = view.querySelector("canvas"), form = view.querySelector("form");
    const scene = JSON.parse(document.getElementById(view.dataset.scene).textContent);
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
    if (!gl) {
      view.textContent = "This browser shows no WebGL 2: the pictures below show the same.";
      return;
    }
    const made = program(gl), at = (name) => gl.getUniformLocation(made, name);
    const field = (name) => form.elements.namedItem(name);
    const box = scene.box, middle = [0, 1, 2].map((k) => (box[0][k] + box[1][k]) / 2);
    const radius = Math.hypot(...[0, 1, 2].map((k) => box[1][k] - box[0][k])) / 2;
    let around = Math.atan2(scene.towards[1], scene.towards[0]), up = Math.asin(scene.towards[2] / Math.hypot(...scene.towards));
    let zoom = 0.92, parts = {};

    scene.cracks.forEach((crack, k) => field("increment").add(new Option(crack.name, k)));
    field("increment").value = scene.cracks.length - 1;

    function fill() {
      const crack = scene.cracks[field("increment").value], colour = field("colour").value;
      parts = {
        skin: upload(gl, made, triangles(scene.skin, box, scene.lengths, scene.lengths, colour)),
        opened: upload(gl, made, triangles(scene.opened, box, scene.lengths, scene.lengths, colour)),
        lip: upload(gl, made, triangles(crack.lip, crack.box, crack.lengths, scene.lengths, colour)),
        front: upload(gl, made, lines(crack.fronts, crack.box)),
      };
      const size = (value) => `${value.toPrecision(2)} ${view.dataset.unit}`;
      view.querySelector("output").textContent = colour === "length"
        ? `dark ${size(scene.lengths[0])}, light ${size(scene.lengths[1])}` : "crack light, front red";
      draw();
    }

    function draw() {
      const dense = window.devicePixelRatio || 1;
      canvas.width = canvas.clientWidth * dense;
      canvas.height = canvas.clientHeight * dense;
      gl.viewport(0, 0, canvas.width, canvas.height);
      const towards = [Math.cos(up) * Math.cos(around), Math.cos(up) * Math.sin(around), Math.sin(up)];
      const right = [-Math.sin(around), Math.cos(around), 0];
      const above = [towards[1] * right[2] - towards[2] * right[1], towards[2] * right[0] - towards[0] * right[2],
        towards[0] * right[1] - towards[1] * right[0]];
      const turn = [0, 1, 2].flatMap((k) => [right[k], above[k], towards[k]]);
      const least = Math.min(canvas.width, canvas.height), scale = zoom / radius;
      gl.uniformMatrix3fv(at("turn"), false, turn);
      gl.uniform3fv(at("middle"), middle);
      gl.uniform2f(at("scale"), (scale * least) / canvas.width, (scale * least) / canvas.height);
      gl.uniform1f(at("depth"), 0.99 / radius);
      const [red, green, blue] = getComputedStyle(canvas).backgroundColor.match(/[\d.]+/g).map((value) => value / 255);
      gl.clearColor(red, green, blue, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LEQUAL);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
      const show = (part, kind, clear, flatly) => {
        gl.uniform1f(at("clear"), clear);
        gl.uniform1f(at("flatly"), flatly);
        gl.bindVertexArray(part.array);
        gl.drawArrays(kind, 0, part.count);
      };
      // the lip lies a little nearer than the body that is cut along it
      gl.uniform3f(at("aside"), 0, 0, -0.004);
      show(parts.lip, gl.TRIANGLES, 1, 0);
      // lines are one pixel wide: several beside each other, a little nearer than the lip
      for (const [x, y] of [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]]) {
        gl.uniform3f(at("aside"), (2 * dense * x) / canvas.width, (2 * dense * y) / canvas.height, -0.008);
        show(parts.front, gl.LINES, 1, 1);
      }
      gl.uniform3f(at("aside"), 0, 0, 0);
      const body = field("body").value / 100, shown = field("cut").checked ? parts.opened : parts.skin;
      if (body < 1) {
        // facets that are turned away come first, then those in front: right for bodies without hollows
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
        gl.depthMask(false);
        gl.enable(gl.CULL_FACE);
        for (const side of [gl.FRONT, gl.BACK]) {
          gl.cullFace(side);
          show(shown, gl.TRIANGLES, body, 0);
        }
        gl.disable(gl.CULL_FACE);
      } else show(shown, gl.TRIANGLES, 1, 0);
    }

    const fingers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
    });
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
    };
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const apart = fingers.size > 1 ? spread() : 0;
      fingers.set(event.pointerId, event);
      if (apart) zoom *= spread() / apart;
      else {
        around -= (event.clientX - before.clientX) * 0.008;
        up = Math.min(Math.max(up + (event.clientY - before.clientY) * 0.008, -1.57), 1.57);
      }
      draw();
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom *= Math.exp(-event.deltaY * 0.001);
      draw();
    }, { passive: false });
    field("increment").addEventListener("input", fill);
    field("colour").addEventListener("input", fill);
    field("body").addEventListener("input", draw);
    field("cut").addEventListener("input", draw);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
    new ResizeObserver(draw).observe(canvas);
    fill();
  }

  // a browser keeps some 16 pictures of WebGL: but for the first, a view starts when it is first seen
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting) {
        seen.unobserve(entry.target);
        start(entry.target);
      }
    }
  });
  document.querySelectorAll(".view").forEach((view, k) => (k ? seen.observe(view) : start(view)));
})();
