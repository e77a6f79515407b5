// The heat map of the report: drawn from the matrix that is embedded in the page, sorted by name,
// clusters, label or the distances to one mesh. Without this script the rest of the page is whole.
"use strict";
(() => {
  const source = document.getElementById("matrix-data");
  if (!source) return;
  const matrix = JSON.parse(source.textContent);
  const count = matrix.names.length;
  const bytes = Uint8Array.from(atob(matrix.cells), (c) => c.charCodeAt(0));
  const wide = matrix.bits === 16;
  const largest = wide ? 65535 : 255;

  // Code of a cell: 0 is no value, 1..largest run from low to high.
  const placeOf = (row, column) => {
    if (!matrix.symmetric) return row * count + column;
    const [a, b] = row > column ? [row, column] : [column, row];
    return (a * (a - 1)) / 2 + b;  // Below the diagonal, row by row.
  };
  const codeOf = (row, column) => {
    if (row === column) return 0;
    const place = placeOf(row, column);
    return wide ? bytes[2 * place] + 256 * bytes[2 * place + 1] : bytes[place];
  };
  const valueOf = (code) =>
    code === 0 ? NaN : matrix.low + ((code - 1) / (largest - 1)) * (matrix.high - matrix.low);
  const text = (value) =>
    Number.isNaN(value) ? "no value" : value.toPrecision(wide ? 4 : 3) + (matrix.unit ? " " + matrix.unit : "");

  // Colour of each code, as the bytes of a pixel. They are spread from color_low to color_high, so
  // that one far value does not take them all.
  const shades = matrix.colors.length / 3;
  const pixelOf = new Uint32Array(largest + 1);
  const packed = (red, green, blue) => new Uint32Array(new Uint8Array([red, green, blue, 255]).buffer)[0];
  pixelOf[0] = packed(150, 150, 150);
  for (let code = 1; code <= largest; ++code) {
    const share = (valueOf(code) - matrix.color_low) / (matrix.color_high - matrix.color_low);
    const shade = 3 * Math.round(Math.min(1, Math.max(0, share)) * (shades - 1));
    pixelOf[code] = packed(...matrix.colors.slice(shade, shade + 3));
  }
  const diagonal = packed(240, 240, 240);

  const canvas = document.getElementById("map");
  const mark = document.getElementById("map-mark");
  const said = document.getElementById("map-said");
  const sort = document.getElementById("map-sort");
  const mesh = document.getElementById("map-mesh");
  const side = Math.max(1, Math.min(48, Math.floor(620 / count)));
  // Names stand left of the rows while they can be read; columns are in the order of the rows.
  const font = Math.min(13, side - 1) + "px DejaVu Sans, Verdana, sans-serif";
  const widest = () => {
    const context = canvas.getContext("2d");
    context.font = font;
    return Math.max(...matrix.short_names.map((name) => context.measureText(name).width));
  };
  const margin = matrix.short_names.length === count ? Math.ceil(widest() + 12) : 0;
  canvas.width = margin + side * count;
  canvas.height = side * count;
  let order = [...Array(count).keys()];
  let at = null;  // {row, column}: places in the picture.

  const draw = () => {
    const image = new ImageData(count, count);
    const pixels = new Uint32Array(image.data.buffer);
    for (let r = 0; r < count; ++r) {
      for (let c = 0; c < count; ++c) {
        pixels[r * count + c] = r === c ? diagonal : pixelOf[codeOf(order[r], order[c])];
      }
    }
    const small = document.createElement("canvas");
    small.width = small.height = count;
    small.getContext("2d").putImageData(image, 0, 0);
    const context = canvas.getContext("2d");
    context.imageSmoothingEnabled = false;
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.drawImage(small, margin, 0, side * count, side * count);
    if (margin === 0) return;
    context.font = font;
    context.fillStyle = "#222";
    context.textAlign = "right";
    context.textBaseline = "middle";
    order.forEach((i, row) =>
      context.fillText(matrix.short_names[i], margin - 6, (row + 0.5) * side));
  };

  const show = () => {
    if (!at) return;
    const row = order[at.row];
    const column = order[at.column];
    const label = (i) => matrix.names[i] + (matrix.persons[i] ? " (" + matrix.persons[i] + ")" : "");
    const lines = row === column
      ? [label(row), "the mesh itself"]
      : [label(row), (matrix.symmetric ? "and " : "to ") + label(column), text(valueOf(codeOf(row, column)))];
    said.replaceChildren(...lines.flatMap((line, i) => {
      const part = document.createElement(i === lines.length - 1 ? "strong" : "span");
      part.textContent = line;
      return i === 0 ? [part] : [document.createElement("br"), part];
    }));
    const scale = canvas.clientWidth / canvas.width;
    const cell = scale * side;
    const box = Math.max(cell, 5);
    const left = canvas.offsetLeft + canvas.clientLeft + scale * margin;
    mark.style.display = "block";
    mark.style.width = mark.style.height = box + "px";
    mark.style.left = left + (at.column + 0.5) * cell - box / 2 + "px";
    mark.style.top = canvas.offsetTop + canvas.clientTop + (at.row + 0.5) * cell - box / 2 + "px";
  };

  const placeUnder = (event) => {
    const frame = canvas.getBoundingClientRect();
    const scale = canvas.clientWidth / canvas.width;
    const place = (offset) => Math.min(count - 1, Math.max(0, Math.floor(offset / scale / side)));
    return {
      row: place(event.clientY - frame.top - canvas.clientTop),
      column: place(event.clientX - frame.left - canvas.clientLeft - scale * margin),
    };
  };

  const reorder = () => {
    const names = [...Array(count).keys()];
    if (sort.value === "clusters") {
      order = matrix.clusters.slice();
    } else if (sort.value === "person") {
      // Unknown ones last; the order of names within a person stays.
      const key = (i) => (matrix.persons[i] ? "0" + matrix.persons[i] : "1");
      order = names.sort((a, b) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : a - b));
    } else if (sort.value === "mesh") {
      const to = Number(mesh.value);
      const key = (i) => {
        if (i === to) return -Infinity;
        const value = valueOf(codeOf(i, to));
        return Number.isNaN(value) ? Infinity : value;
      };
      order = names.sort((a, b) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : a - b));
    } else {
      order = names;
    }
    mesh.parentElement.hidden = sort.value !== "mesh";
    draw();
    show();
  };

  canvas.addEventListener("mousemove", (event) => { at = placeUnder(event); show(); });
  canvas.addEventListener("click", (event) => {
    at = placeUnder(event);
    mesh.value = String(order[at.column]);
    sort.value = "mesh";
    reorder();
  });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const inside = (place) => Math.min(count - 1, Math.max(0, place));
    at = at ? { row: inside(at.row + step[0]), column: inside(at.column + step[1]) } : { row: 0, column: 0 };
    show();
  });
  window.addEventListener("resize", show);
  matrix.names.forEach((name, i) => mesh.add(new Option(name, String(i))));
  sort.addEventListener("change", reorder);
  mesh.addEventListener("change", reorder);
  sort.value = matrix.clusters.length === count ? "clusters" : "name";
  reorder();
})();
