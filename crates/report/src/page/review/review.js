// Fills the page of a review from its packed data: what was added, the path, and all lines side by side.
//
// The data are integers in typed arrays, since there may be a million lines; the text of a line is put together when it is shown.
// Text of programs reaches the page by `textContent` only, so that nothing in it can become markup.
(() => {
'use strict';

const MM_PER_UM = 1e-3;
const LETTERS = 27;
/** Pieces of a line are counted up to here. */
const MOST_PIECES = 100000;
/** Where a value of a journal is not known. */
const GAP = -2147483648;
const FLAG = { rapid: 1, first: 2, spot: 4, unstated: 8, feed: 16 };
const UNIT = { um: 'µm', urad: 'µrad' };

// ---------------------------------------------------------------- small helpers

const byId = id => document.getElementById(id);
const grouped = number => number.toLocaleString('en-US');
const clamp = (value, least, most) => Math.min(most, Math.max(least, value));
const baseName = path => path.split(/[\\/]/).pop();

/** An element with properties and children; texts become text nodes. */
function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith('aria') || name === 'role' || name === 'for') element.setAttribute(name, value);
    else element[name] = value;
  }
  element.append(...children);
  return element;
}

function signed(value, digits) {
  const text = Math.abs(value).toFixed(digits);
  return value === 0 ? '0' : (value < 0 ? '−' : '+') + text;
}

/** Calls at most once a frame. */
function oncePerFrame(call) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; call(); });
  };
}

/** The first place in ascending values from which on they are at least `value`. */
function firstNotBelow(values, value, count = values.length) {
  let [from, to] = [0, count];
  while (from < to) {
    const middle = (from + to) >> 1;
    if (values[middle] < value) from = middle + 1; else to = middle;
  }
  return from;
}

/** Runs generators in slices, so that the page stays responsive; a task with the name of another one replaces it. */
const slices = {
  tasks: new Map(),
  isWaiting: false,
  start(name, generator, done = () => {}) {
    this.tasks.set(name, { generator, done });
    this.goOn();
  },
  goOn() {
    if (this.isWaiting || this.tasks.size === 0) return;
    this.isWaiting = true;
    setTimeout(() => { this.isWaiting = false; this.run(); });
  },
  stop(name) { this.tasks.delete(name); },
  run() {
    const until = performance.now() + 10;
    for (const [name, task] of this.tasks) {
      let step = { done: false };
      while (!step.done && performance.now() < until) step = task.generator.next();
      if (step.done && this.tasks.get(name) === task) {
        this.tasks.delete(name);
        task.done(step.value);
      }
      if (performance.now() >= until) break;
    }
    this.goOn();
  },
};

// ---------------------------------------------------------------- colors

/** Pale to strong on light paper, dull to bright on dark: the largest deviations stand out on both. */
const RAMPS = {
  light: ['#8fbbdf', '#6aa5d3', '#4a8cc4', '#5473bb', '#6f5bb0', '#8a46a2', '#a3358a', '#b52766', '#c01f3c'],
  dark: ['#33608f', '#3f7ab0', '#5a8fcd', '#8295dc', '#a99ae2', '#cf9fd6', '#eda6b4', '#ffb98a', '#ffe08a'],
};
const CLASSES = RAMPS.light.length;
/** A printer has paper, whatever the screen shows. */
const PRINTED = {
  paper: '#fff', ink: '#000', soft: '#444', grid: '#ccc', bad: '#900',
  s0: '#0072b2', s1: '#d55e00', s2: '#009e73', s3: '#b0508a', s4: '#a67c00', s5: '#4a5568',
};
const darkScheme = matchMedia('(prefers-color-scheme: dark)');

const theme = {
  printing: false,
  colors: {},
  read() {
    const style = getComputedStyle(document.documentElement);
    const screen = name => style.getPropertyValue(`--${name}`).trim() || PRINTED[name];
    this.colors = this.printing ? PRINTED : Object.fromEntries(Object.keys(PRINTED).map(name => [name, screen(name)]));
    this.ramp = this.printing || !darkScheme.matches ? RAMPS.light : RAMPS.dark;
  },
  series(number) { return this.colors[`s${number % 6}`]; },
};

// ---------------------------------------------------------------- packed data

function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let at = 0; at < bytes.length; at++) bytes[at] = binary.charCodeAt(at);
  return bytes;
}

/** The header, and the streams by name. */
async function unpack(text) {
  const unzipped = new Blob([fromBase64(text.trim())]).stream().pipeThrough(new DecompressionStream('gzip'));
  const bytes = new Uint8Array(await new Response(unzipped).arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const streams = new Map();
  let at = 4 + length;
  for (const stream of header.streams) {
    const own = bytes.subarray(at, at + stream.bytes);
    streams.set(stream.name, smallIntegers(own, stream) ?? largeIntegers(own, stream));
    at += stream.bytes;
  }
  return { header, streams };
}

/** A stream of which every value has 32 bits; null where one has not. */
function smallIntegers(bytes, { count, order }) {
  const out = new Int32Array(count);
  let [at, last, before] = [0, 0, 0];
  for (let place = 0; place < count; place++) {
    let byte = bytes[at++];
    let folded = byte & 0x7f;
    for (let factor = 128; byte > 0x7f; factor *= 128) {
      byte = bytes[at++];
      folded += (byte & 0x7f) * factor;
    }
    const difference = folded % 2 === 0 ? folded / 2 : -(folded + 1) / 2;
    const value = order === 0 ? difference : order === 1 ? last + difference : 2 * last - before + difference;
    if (value !== (value | 0)) return null;
    before = last;
    last = value;
    out[place] = value;
  }
  return out;
}

/** The same for values of any size: differences of large numbers need more bits than a double has. */
function largeIntegers(bytes, { count, order }) {
  const out = new BigInt64Array(count);
  let [at, last, before] = [0, 0n, 0n];
  for (let place = 0; place < count; place++) {
    let [folded, shift, byte] = [0n, 0n, 0];
    do {
      byte = bytes[at++];
      folded |= BigInt(byte & 0x7f) << shift;
      shift += 7n;
    } while (byte > 0x7f);
    const difference = (folded >> 1n) ^ -(folded & 1n);
    const value = order === 0 ? difference : order === 1 ? last + difference : 2n * last - before + difference;
    [before, last] = [last, BigInt.asIntN(64, value)];
    out[place] = last;
  }
  return out;
}

// ---------------------------------------------------------------- texts

const isLetter = code => (code >= 65 && code <= 90) || (code >= 97 && code <= 122);
const letterName = letter => (letter === LETTERS - 1 ? '_' : String.fromCharCode(65 + letter));

/** Templates, with the letters of their numbers in one array. */
class Templates {
  constructor(templates, scales) {
    this.all = templates;
    this.scales = Array.from({ length: LETTERS }, (_, letter) => scales[letterName(letter)] ?? 0);
    this.start = new Uint32Array(templates.length + 1);
    const letters = [];
    templates.forEach((template, number) => {
      this.start[number] = letters.length;
      let letter = LETTERS - 1;
      for (let at = 0; at < template.length; at++) {
        const code = template.charCodeAt(at);
        if (code === 1) {
          letters.push(letter);
          at++;
        } else if (isLetter(code)) letter = (code & 0xdf) - 65;
      }
    });
    this.start[templates.length] = letters.length;
    this.letters = Uint8Array.from(letters);
    this.taken = [];
  }

  /** A template taken apart: the texts before, between and behind its numbers, and how each number was written. */
  pieces(number) {
    if (!this.taken[number]) {
      const parts = (this.all[number] ?? '').split('\u0001');
      const texts = parts.map((part, place) => (place === 0 ? part : part.slice(1)));
      this.taken[number] = { texts, kinds: parts.slice(1).map(part => part.charCodeAt(0) - 0x30), start: this.start[number] };
    }
    return this.taken[number];
  }

  /** Counts the numbers of a template. */
  count(template, counts) {
    for (let at = this.start[template]; at < this.start[template + 1]; at++) counts[this.letters[at]]++;
  }
}

/** A number as it was written: `kind` is 0 without a point, else decimals + 1. */
function written(value, scale, kind) {
  const decimals = Math.max(0, kind - 1);
  const number = scale === decimals ? value : Math.round(value / 10 ** (scale - decimals));
  if (decimals === 0) return kind > 0 ? `${number}.` : String(number);
  const digits = String(Math.abs(number)).padStart(decimals + 1, '0');
  const whole = digits.slice(0, digits.length - decimals);
  return `${number < 0 ? '-' : ''}${whole}.${digits.slice(digits.length - decimals)}`;
}

/** A program: its lines are put together when they are asked for. */
class ProgramText {
  /** Counts of numbers are kept at every so many lines. */
  static STRIDE = 64;

  constructor({ name, lines }, key, streams, templates) {
    Object.assign(this, { name, lines, templates });
    this.template = streams.get(`text.${key}.template`) ?? new Int32Array(0);
    this.numbers = Array.from({ length: LETTERS }, (_, letter) => streams.get(`text.${key}.${letterName(letter)}`));
    this.marks = this.countAll();
    this.known = new Uint32Array(LETTERS);
    this.places = new Uint32Array(LETTERS);
    this.knownLine = 0;
  }

  countAll() {
    const { STRIDE } = ProgramText;
    const marks = new Uint32Array(LETTERS * (Math.floor(this.template.length / STRIDE) + 1));
    const counts = new Uint32Array(LETTERS);
    for (let line = 0; line < this.template.length; line++) {
      if (line % STRIDE === 0) marks.set(counts, LETTERS * (line / STRIDE));
      this.templates.count(this.template[line], counts);
    }
    if (this.template.length % STRIDE === 0) marks.set(counts, LETTERS * (this.template.length / STRIDE));
    return marks;
  }

  /** How many numbers of each letter the first `line` lines have; going forward is cheap. */
  counts(line) {
    const { STRIDE } = ProgramText;
    if (line < this.knownLine || line - this.knownLine > STRIDE) {
      const mark = Math.floor(line / STRIDE);
      this.known.set(this.marks.subarray(LETTERS * mark, LETTERS * (mark + 1)));
      this.knownLine = mark * STRIDE;
    }
    for (; this.knownLine < line; this.knownLine++) this.templates.count(this.template[this.knownLine], this.known);
    return this.known;
  }

  /** The last number of a letter in the first `line` lines. */
  lastNumber(letter, line) {
    const count = this.counts(line)[letter];
    return count === 0 ? 0 : this.numbers[letter][count - 1];
  }

  /** What is to be added to a number that is stored; the corrected program has a base. */
  value(stored) { return Number(stored); }

  /** A line, from 1: its text, and its numbers with their places, which `told` takes. */
  put(line, told) {
    const { texts, kinds, start } = this.templates.pieces(this.template[line - 1]);
    this.places.set(this.counts(line - 1));
    let text = texts[0];
    for (let slot = 0; slot < kinds.length; slot++) {
      const letter = this.templates.letters[start + slot];
      const value = this.value(this.numbers[letter][this.places[letter]++], letter, line);
      const digits = written(value, this.templates.scales[letter], kinds[slot]);
      told?.push({ letter, start: text.length, text: digits });
      text += digits + texts[slot + 1];
    }
    return text;
  }

  parts(line) {
    const numbers = [];
    return { text: this.put(line, numbers), numbers };
  }
}

/** The corrected program holds what its numbers differ by from the last of the same letter in the original. */
class CorrectedText extends ProgramText {
  constructor(file, streams, templates, original, reached) {
    super(file, 'c', streams, templates);
    Object.assign(this, { original, reached });
  }

  value(stored, letter, line) {
    const base = this.original.lastNumber(letter, this.reached[line - 1]);
    return typeof stored === 'bigint' || typeof base === 'bigint' ? Number(BigInt(stored) + BigInt(base)) : stored + base;
  }
}

// ---------------------------------------------------------------- the review

/** Everything about rows and lines that does not change while one looks at it. */
class Review {
  constructor({ header, streams }) {
    this.header = header;
    this.count = header.rows;
    const column = name => streams.get(name) ?? new Int32Array(this.count);
    this.axes = header.axes;
    this.step = this.axes[0]?.scale ?? 0.01;
    [this.file, this.line, this.corrected] = ['file', 'line', 'corrected'].map(name => column(`row.${name}`));
    this.flags = Uint8Array.from(column('row.flags'));
    this.added = this.axes.map(({ name }) => column(`row.add.${name}`));
    this.at = [0, 1, 2].map(number => column(`row.at.${number}`));
    const via = name => streams.get(`via.${name}`) ?? new Int32Array(0);
    this.via = { row: via('row'), at: [0, 1, 2].map(number => via(`at.${number}`)) };
    this.pair = streams.get('pair') ?? new Int32Array(0);
    this.unit = this.axes.find(({ unit }) => unit === 'um')?.unit ?? this.axes[0]?.unit ?? 'um';
    this.size = this.sizes(this.added.filter((_, number) => this.axes[number].unit === this.unit));
    this.largest = this.size.reduce((most, size) => Math.max(most, size), 0);
    this.palest = this.paleSize();
    this.readTexts(streams);
    this.readMoves();
    this.readTools();
    this.readItems();
  }

  /** The largest of what was added to some axes of one unit: linear axes where there are any, else rotary ones. */
  sizes(columns) {
    const out = new Int32Array(this.count);
    for (const values of columns) {
      for (let row = 0; row < out.length; row++) out[row] = Math.max(out[row], Math.abs(values[row]));
    }
    return out;
  }

  /** Colors begin at 0, or where nearly all sizes are far from it, at these: else all of the path has one color. */
  paleSize() {
    const low = ranked(this.size.slice(), this.largest, Math.floor(0.02 * this.count));
    return low > 0.3 * this.largest && low < this.largest ? low : 0;
  }

  colorClass(size) {
    const part = (size - this.palest) / Math.max(1, this.largest - this.palest);
    return clamp(Math.floor(CLASSES * part), 0, CLASSES - 1);
  }

  readTexts(streams) {
    const { header } = this;
    const templates = new Templates(header.templates, header.scales);
    const reached = new Int32Array(this.pair.length);
    let most = 0;
    this.pair.forEach((line, place) => { reached[place] = most = Math.max(most, line); });
    this.originals = header.files.map((file, number) => new ProgramText(file, number, streams, templates));
    this.original = this.originals[0];
    this.text = new CorrectedText(header.corrected, streams, templates, this.original, reached);
  }

  /** Whether the move of a row has several pieces, and whether nothing was added to any of them. */
  readMoves() {
    this.split = new Uint8Array(this.count);
    this.alone = new Uint8Array(this.count);
    const close = (from, to) => {
      let [pieces, most] = [0, 0];
      for (let row = from; row < to; row++) {
        if (!(this.flags[row] & FLAG.spot)) pieces++;
        if (this.added.some(values => values[row] !== 0)) most = 1;
      }
      if (pieces > 1) this.split.fill(1, from, to);
      if (most === 0) this.alone.fill(1, from, to);
    };
    let from = 0;
    for (let row = 1; row < this.count; row++) {
      if (this.flags[row] & FLAG.first) {
        close(from, row);
        from = row;
      }
    }
    close(from, this.count);
  }

  /** The tool of each row as a number of `toolNames`; the first name stands for none yet. */
  readTools() {
    this.toolNames = [''];
    this.tool = new Uint16Array(this.count);
    this.header.tools.forEach(({ row, name }, place) => {
      let number = this.toolNames.indexOf(name);
      if (number < 0) number = this.toolNames.push(name) - 1;
      this.tool.fill(number, row, this.header.tools[place + 1]?.row ?? this.count);
    });
  }

  /** The lines of the list: each line of the corrected program, and between them lines of the original that nothing came of. */
  readItems() {
    const [lines, own] = [this.original.lines, this.pair.length];
    const named = new Uint8Array(lines + 1);
    this.pair.forEach(line => { named[line] = 1; });
    this.itemOriginal = new Uint32Array(lines + own);
    this.itemCorrected = new Uint32Array(lines + own);
    this.itemOf = new Uint32Array(own + 1);
    let [count, reached] = [0, 0];
    const dropped = upTo => {
      while (reached < upTo) if (!named[++reached]) this.itemOriginal[count++] = reached;
    };
    for (let line = 1; line <= own; line++) {
      const before = this.pair[line - 1];
      if (before > reached) {
        dropped(before - 1);
        reached = before;
      }
      this.itemOriginal[count] = before;
      this.itemCorrected[count] = line;
      this.itemOf[line] = count++;
    }
    dropped(lines);
    this.items = count;
    this.readRowsOfLines(own);
  }

  /** The row that stands for a line of the corrected program: of a line that is executed several times the largest. */
  readRowsOfLines(own) {
    this.rowOf = new Int32Array(own + 1).fill(-1);
    this.timesOf = new Uint32Array(own + 1);
    for (let row = 0; row < this.count; row++) {
      const line = this.corrected[row];
      const known = this.rowOf[line];
      this.timesOf[line]++;
      if (known < 0 || this.size[row] > this.size[known]) this.rowOf[line] = row;
    }
  }

  rowOfItem(item) { return this.itemCorrected[item] ? this.rowOf[this.itemCorrected[item]] : -1; }

  /** The original of an item: its text and its line; rows of subprograms name another file. */
  originalOf(item) {
    const line = this.itemOriginal[item];
    if (line) return { text: this.original, line, file: 0 };
    const row = this.rowOfItem(item);
    const file = row < 0 ? 0 : this.file[row];
    return file > 0 && this.originals[file] ? { text: this.originals[file], line: this.line[row], file } : null;
  }

  /** Which of how many pieces of a line of the original an item is. */
  group(item) {
    const line = this.itemOriginal[item];
    const isInList = other => other >= 0 && other < this.items;
    const isSame = other => isInList(other) && this.itemCorrected[other] > 0 && this.itemOriginal[other] === line;
    if (!line || !this.itemCorrected[item]) return { place: 0, count: 1 };
    let [from, to] = [item, item];
    while (item - from < MOST_PIECES && isSame(from - 1)) from--;
    while (to - item < MOST_PIECES && isSame(to + 1)) to++;
    return { place: item - from, count: to - from + 1 };
  }
}

/** Figures of an axis, as `ncfix diff` has them: the first of the largest, the mean with its sign. */
function figuresOf(values, lines, step) {
  let [most, sum, squares] = [0, 0, 0];
  const sizes = new Int32Array(values.length);
  for (let row = 0; row < values.length; row++) {
    const size = Math.abs(values[row]);
    sizes[row] = size;
    sum += values[row];
    squares += size * size;
    if (size > sizes[most]) most = row;
  }
  const count = Math.max(1, values.length);
  return {
    max: step * (values[most] ?? 0),
    max_line: lines[most],
    mean: step * sum / count,
    rms: step * Math.sqrt(squares / count),
    p99: step * ranked(sizes, sizes[most] ?? 0, Math.ceil(0.99 * count) - 1),
  };
}

/** The value at a place if all were sorted. Sizes are mostly small, and counting them is faster than sorting. */
function ranked(sizes, most, place) {
  if (most > 4e6) return sizes.sort()[place] ?? 0;
  const counts = new Uint32Array(most + 1);
  for (const size of sizes) counts[size]++;
  let [value, below] = [0, counts[0]];
  while (below <= place && value < most) below += counts[++value];
  return value;
}

/** Rows by falling size, the earlier first. */
class Order {
  constructor(sizes, passes) {
    this.sizes = sizes;
    const factor = Math.max(1, sizes.length);
    let [most, count] = [0, 0];
    for (let row = 0; row < sizes.length; row++) {
      if (passes && !passes[row]) continue;
      most = Math.max(most, sizes[row]);
      count++;
    }
    const keys = new Float64Array(count);
    for (let row = 0, at = 0; row < sizes.length; row++) {
      if (!passes || passes[row]) keys[at++] = (most - sizes[row]) * factor + row;
    }
    keys.sort();
    this.rows = Uint32Array.from(keys, key => key % factor);
  }

  /** The row so many places behind another one, which need not be among them. */
  beside(row, places) {
    if (this.rows.length === 0) return -1;
    if (row < 0) return this.rows[places > 0 ? 0 : this.rows.length - 1];
    const isBefore = other => this.sizes[other] > this.sizes[row] || (this.sizes[other] === this.sizes[row] && other < row);
    let [from, to] = [0, this.rows.length];
    while (from < to) {
      const middle = (from + to) >> 1;
      if (isBefore(this.rows[middle])) from = middle + 1; else to = middle;
    }
    const isThere = this.rows[from] === row;
    const place = places > 0 ? from + (isThere ? 1 : 0) : from - 1;
    return this.rows[clamp(place, 0, this.rows.length - 1)];
  }
}

// ---------------------------------------------------------------- line plots

/** Points that draw the same picture as all of them: of each stretch the smallest and the largest, in their order. */
function thinned(x, columns, from, to, most) {
  const count = to - from;
  const value = (values, row) => (values[row] === GAP ? null : values[row]);
  if (count <= 2 * most) {
    const rows = Array.from({ length: count }, (_, place) => from + place);
    return [rows.map(row => x[row]), ...columns.map(({ values, scale }) =>
      rows.map(row => (value(values, row) === null ? null : scale * values[row])))];
  }
  const edges = Array.from({ length: most + 1 }, (_, place) => from + Math.floor(place * count / most));
  const places = edges.slice(1).flatMap((edge, place) => [x[edges[place]], x[edge - 1]]);
  return [places, ...columns.map(column => extremes(column, edges))];
}

function extremes({ values, scale }, edges) {
  const out = new Array(2 * (edges.length - 1));
  for (let stretch = 0; stretch + 1 < edges.length; stretch++) {
    let [least, most] = [-1, -1];
    for (let row = edges[stretch]; row < edges[stretch + 1]; row++) {
      if (values[row] === GAP) continue;
      if (least < 0 || values[row] < values[least]) least = row;
      if (most < 0 || values[row] > values[most]) most = row;
    }
    const [first, second] = least < most ? [least, most] : [most, least];
    out[2 * stretch] = first < 0 ? null : scale * values[first];
    out[2 * stretch + 1] = second < 0 ? null : scale * values[second];
  }
  return out;
}

/** A plot of columns over ascending places; zooms by dragging, and draws as many points as there is room for. */
class LinePlot {
  constructor(place, { x, columns, xLabel, yLabel, rightLabel = null, height = 260, label, drawn = () => {}, picked = () => {}, moved = () => {} }) {
    Object.assign(this, { place, x, columns, height, drawn, picked, moved, xLabel, yLabel, rightLabel });
    this.shown = columns.map(() => true);
    place.setAttribute('role', 'img');
    place.setAttribute('aria-label', label);
    this.range = this.whole();
    this.plot = new uPlot(this.options(), this.data(), place);
    this.isReady = true;
    this.listen();
    new ResizeObserver(oncePerFrame(() => this.fit())).observe(place);
  }

  whole() {
    const [from, to] = [this.x[0] ?? 0, this.x[this.x.length - 1] ?? 1];
    return to > from ? [from, to] : [from - 1, from + 1];
  }

  width() { return Math.max(240, (theme.printing ? 660 : this.place.clientWidth) || 600); }

  options() {
    const axis = label => ({
      label, labelSize: 22, labelFont: '12px system-ui', font: '11px system-ui', labelGap: 0,
      stroke: () => theme.colors.soft,
      grid: { stroke: () => theme.colors.grid, width: 1 },
      ticks: { stroke: () => theme.colors.grid, width: 1, size: 4 },
    });
    const series = ({ name, dash, color, side }) => ({
      label: name, dash, scale: side === 'right' ? 'right' : 'y', stroke: () => theme.series(color), width: 1, points: { show: false },
    });
    return {
      width: this.width(), height: this.height, legend: { show: false }, padding: [8, this.rightLabel ? 0 : 30, 0, 0],
      cursor: {
        drag: { x: true, y: false, setScale: false },
        points: { size: 5 },
        bind: { dblclick: () => () => { this.zoom(this.whole()); return null; } },
      },
      scales: { x: { time: false, range: () => this.range }, ...this.heights() },
      axes: [
        { ...axis(this.xLabel()), size: 26 }, { ...axis(this.yLabel), size: 52 },
        ...(this.rightLabel ? [{ ...axis(this.rightLabel), size: 52, side: 1, scale: 'right', grid: { show: false } }] : []),
      ],
      series: [{}, ...this.columns.map(series)],
      hooks: {
        setSelect: [plot => this.selected(plot)], draw: [plot => this.drawn(plot)], setCursor: [plot => this.moved(plot)],
      },
    };
  }

  /** Range of each vertical axis. With two of them 0 is in the middle of both, so that they share one line. */
  heights() {
    const own = { range: (_, least, most) => padded(least, most) };
    if (!this.rightLabel) return { y: own };
    const balanced = { range: (_, least, most) => padded(-Math.max(-least, most), Math.max(-least, most)) };
    return { y: balanced, right: balanced };
  }

  data() {
    const from = Math.max(0, firstNotBelow(this.x, this.range[0]) - 1);
    const past = firstNotBelow(this.x, this.range[1]);
    let to = past;
    while (to < this.x.length && to < past + 1) to++;
    // Places that many rows share end the range together.
    while (to < this.x.length && this.x[to] <= this.range[1]) to++;
    return thinned(this.x, this.columns, from, to, Math.max(400, Math.min(1600, this.width())));
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    const [from, to] = [plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x')];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (to > from) this.zoom([from, to]);
  }

  zoom(range) {
    const [least, most] = this.whole();
    const width = Math.min(range[1] - range[0], most - least);
    const from = clamp(range[0], least, most - width);
    this.range = [from, from + width];
    this.update();
  }

  /** Moves the range so that a place is in it. */
  reveal(x) {
    if (x >= this.range[0] && x <= this.range[1]) return;
    const half = (this.range[1] - this.range[0]) / 2;
    this.zoom([x - half, x + half]);
  }

  update() { if (this.isReady) this.plot.setData(this.data(), true); }

  redraw() { this.plot.redraw(false, true); }

  fit() {
    const width = this.width();
    if (width === this.plot.width) return;
    this.plot.setSize({ width, height: this.height });
    this.update();
  }

  show(column, isShown) {
    this.shown[column] = isShown;
    this.plot.setSeries(column + 1, { show: isShown });
  }

  /** A press and a release at one place are a click; a drag zooms. */
  listen() {
    let down = null;
    const { over } = this.plot;
    over.addEventListener('mousedown', event => { down = [event.clientX, event.clientY]; });
    over.addEventListener('mouseup', event => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) {
        const box = over.getBoundingClientRect();
        this.picked(event.clientX - box.left, event.clientY - box.top);
      }
      down = null;
    });
  }

  print() {
    this.fit();
    this.redraw();
  }
}

/** Room above and below. */
function padded(least, most) {
  if (least === null || most === null || !Number.isFinite(least)) return [-1, 1];
  const room = 0.08 * (most - least) || 0.1 * Math.abs(most) || 1;
  return [least - room, most + room];
}

/** A box to tick, with the color of its line. */
function lineToggle(name, color, changed, isDashed = false) {
  const box = make('input', { type: 'checkbox', checked: true });
  box.addEventListener('change', () => changed(box.checked));
  const swatch = make('i', { className: `swatch c${color % 6}${isDashed ? ' dashed' : ''}` });
  return make('label', { className: 'toggle' }, box, swatch, name);
}

function button(text, title, click) {
  const out = make('button', { type: 'button', title }, text);
  out.addEventListener('click', click);
  return out;
}

function choice(label, options, changed) {
  const select = make('select', {}, ...options.map(([value, text]) => make('option', { value }, text)));
  select.addEventListener('change', () => changed(select.value));
  return { select, label: make('label', {}, make('span', {}, label), select) };
}

/** What was added to each axis, over the lines or the length of the path. */
class DeviationPlot {
  constructor(app) {
    this.app = app;
    const { review } = app;
    this.readings = make('output', { className: 'readings' });
    this.overs = this.places(review);
    const place = byId('deviation-plot');
    byId('deviation-controls').append(...this.controls());
    if (review.count === 0 || review.axes.length === 0) {
      place.append(make('p', { className: 'soft' }, 'There are no corrections.'));
      return;
    }
    const columns = review.axes.map(({ name, scale, unit }, number) => ({
      name, scale, values: review.added[number], color: number, ...(unit === review.unit ? {} : { dash: [6, 3], side: 'right' }),
    }));
    const others = review.axes.filter(({ unit }) => unit !== review.unit);
    this.plot = new LinePlot(place, {
      x: this.overs[0].x, columns, height: 280, label: 'Correction added to each axis',
      xLabel: () => this.over().label, yLabel: `added, ${UNIT[review.unit]}`,
      rightLabel: others.length > 0 ? `${others.map(({ name }) => name).join(', ')} (dashed): added, ${UNIT[others[0].unit]}` : null,
      drawn: plot => this.mark(plot),
      picked: (left, top) => this.pick(left, top),
      moved: plot => this.read(plot),
    });
  }

  /** What can be across. Lines of loops come again: then rows are counted in their place. */
  places(review) {
    const lines = Float64Array.from(review.corrected);
    const isAscending = lines.every((line, row) => row === 0 || line >= lines[row - 1]);
    const byLine = isAscending
      ? { label: 'line of the corrected program', name: 'line', x: lines }
      : { label: 'pieces in the order in which they are executed', name: 'piece', x: lines.map((_, row) => row + 1) };
    return [byLine, { label: 'length of the path, mm', name: 'path length', x: null }];
  }

  over() { return this.overs[this.chosen ?? 0]; }

  controls() {
    const { review } = this.app;
    const toggles = review.axes.map(({ name, unit }, number) => lineToggle(
      `${name}, ${UNIT[unit] ?? unit}`, number, isShown => this.plot?.show(number, isShown), unit !== review.unit,
    ));
    const over = choice('over', this.overs.map(({ name }, number) => [number, name]), value => this.choose(Number(value)));
    over.select.id = 'over';
    const whole = button('Whole', 'The whole range (double-click)', () => this.plot?.zoom(this.plot.whole()));
    const hint = make('span', { className: 'hint' }, 'drag zooms, double-click shows all, click selects');
    return [...toggles, over.label, whole, this.readings, hint];
  }

  choose(number) {
    this.chosen = number;
    const over = this.over();
    over.x ??= lengths(this.app.review);
    if (!this.plot) return;
    this.plot.x = over.x;
    this.plot.range = this.plot.whole();
    this.plot.plot.axes[0].label = over.label;
    this.plot.update();
  }

  /** Line of the selected row, and the threshold. */
  mark(plot) {
    const { ctx } = plot;
    const { left, top, width, height } = plot.bbox;
    const ratio = uPlot.pxRatio;
    const chosen = this.app.review.axes[this.app.filters?.axis.select.value || -1];
    const scale = chosen && chosen.unit !== this.app.review.unit ? 'right' : 'y';
    const across = (y, dash) => {
      const at = plot.valToPos(y, scale, true);
      if (!(at >= top && at <= top + height)) return;
      ctx.setLineDash(dash);
      ctx.beginPath();
      ctx.moveTo(left, at);
      ctx.lineTo(left + width, at);
      ctx.stroke();
    };
    ctx.save();
    ctx.lineWidth = ratio;
    ctx.strokeStyle = theme.colors.soft;
    across(0, []);
    ctx.strokeStyle = theme.colors.bad;
    const threshold = this.app.filters?.threshold ?? 0;
    if (threshold > 0) [threshold, -threshold].forEach(value => across(value, [5 * ratio, 4 * ratio]));
    this.markRow(plot, ctx, ratio);
    ctx.restore();
  }

  markRow(plot, ctx, ratio) {
    const { row } = this.app.selected;
    if (row < 0) return;
    const { left, top, width, height } = plot.bbox;
    const x = plot.valToPos(this.over().x[row], 'x', true);
    if (!(x >= left - 1 && x <= left + width + 1)) return;
    ctx.setLineDash([]);
    ctx.strokeStyle = theme.colors.ink;
    ctx.lineWidth = ratio;
    ctx.strokeRect(x, top, 0, height);
    this.app.review.added.forEach((values, number) => {
      if (!this.plot.shown[number]) return;
      ctx.beginPath();
      ctx.arc(x, plot.valToPos(values[row] * this.app.review.step, 'y', true), 4 * ratio, 0, 2 * Math.PI);
      ctx.fillStyle = theme.series(number);
      ctx.fill();
      ctx.stroke();
    });
  }

  /** Where the marker is, in pixels of the plot; for scripts. */
  markerLeft() {
    const { row } = this.app.selected;
    return row < 0 || !this.plot ? null : this.plot.plot.valToPos(this.over().x[row], 'x');
  }

  /** The row whose point is nearest; where there are many to a pixel, of those few pixels. */
  pick(left, top) {
    const { plot, shown } = this.plot;
    const x = this.over().x;
    const [from, to] = [left - 4, left + 4].map(at => firstNotBelow(x, plot.posToVal(at, 'x')));
    let [nearest, least] = [-1, Infinity];
    const { review } = this.app;
    for (let row = from; row < to; row++) {
      const aside = plot.valToPos(x[row], 'x') - left;
      review.added.forEach((values, number) => {
        if (!shown[number]) return;
        const distance = Math.hypot(aside, plot.valToPos(values[row] * review.step, 'y') - top);
        if (distance < least) [nearest, least] = [row, distance];
      });
    }
    this.app.selectRow(nearest >= 0 ? nearest : this.nearestRow(plot.posToVal(left, 'x')), 'plot');
  }

  nearestRow(value) {
    const x = this.over().x;
    const above = Math.min(x.length - 1, firstNotBelow(x, value));
    return above > 0 && value - x[above - 1] < x[above] - value ? above - 1 : above;
  }

  /** What the plot has where the pointer is. */
  read(plot) {
    const { left } = plot.cursor;
    if (!(left >= 0) || !this.plot) {
      this.readings.textContent = '';
      return;
    }
    const row = this.nearestRow(plot.posToVal(left, 'x'));
    const { review } = this.app;
    const values = review.axes.map(({ name, unit, scale }, number) =>
      `${name} ${signed(review.added[number][row] * scale, 2)} ${UNIT[unit] ?? unit}`);
    this.readings.textContent = `line ${grouped(review.corrected[row])}   ${values.join('   ')}`;
  }

  select({ row }) {
    if (!this.plot) return;
    if (row >= 0) this.plot.reveal(this.over().x[row]);
    this.plot.redraw();
  }

  filter() { this.plot?.redraw(); }
  redraw() { this.plot?.redraw(); }
  print() { this.plot?.print(); }
}

/** The length of the nominal path up to the end of each row, mm. */
function lengths({ count, at: [x, y, z], flags, header }) {
  const out = new Float64Array(count);
  for (let row = 1; row < count; row++) {
    const isKnown = !((flags[row] | flags[row - 1]) & FLAG.unstated);
    const step = isKnown ? Math.hypot(x[row] - x[row - 1], y[row] - y[row - 1], z[row] - z[row - 1]) : 0;
    out[row] = out[row - 1] + step * header.position_mm;
  }
  return out;
}

// ---------------------------------------------------------------- the path

/** Places with what was added to them, in the order of the rows; rows in blocks, so that those outside of a view cost nothing. */
class Path {
  static BLOCK = 256;

  constructor(review) {
    this.count = review.count;
    this.unit = review.header.position_mm;
    this.at = review.at;
    this.via = review.via;
    this.flags = review.flags;
    this.size = review.size;
    const nothing = new Int32Array(review.count);
    this.added = ['X', 'Y', 'Z'].map(name => {
      const number = review.axes.findIndex(axis => axis.name === name && axis.unit === 'um');
      return number < 0 ? nothing : review.added[number];
    });
    this.addedUnit = review.step * MM_PER_UM;
    this.classes = Uint8Array.from(review.size, size => review.colorClass(size));
    this.readVia();
    this.readBoxes();
  }

  /** Which points within arcs each row has: from that number of its own to that of the next row. */
  readVia() {
    this.viaFrom = new Uint32Array(this.count + 1);
    for (const row of this.via.row) this.viaFrom[row + 1]++;
    for (let row = 0; row < this.count; row++) this.viaFrom[row + 1] += this.viaFrom[row];
  }

  readBoxes() {
    const { BLOCK } = Path;
    this.blocks = Math.ceil(this.count / BLOCK);
    this.least = this.at.map(() => new Float64Array(this.blocks).fill(Infinity));
    this.most = this.at.map(() => new Float64Array(this.blocks).fill(-Infinity));
    this.at.forEach((places, axis) => {
      for (let row = 0; row < this.count; row++) {
        if (this.flags[row] & FLAG.unstated) continue;
        // A line comes from the end of the row before.
        for (const block of [Math.floor(row / BLOCK), Math.floor(Math.min(this.count - 1, row + 1) / BLOCK)]) {
          const place = places[row] * this.unit;
          if (place < this.least[axis][block]) this.least[axis][block] = place;
          if (place > this.most[axis][block]) this.most[axis][block] = place;
        }
      }
      this.via.at[axis].forEach((at, number) => {
        const [block, place] = [Math.floor(this.via.row[number] / BLOCK), at * this.unit];
        if (place < this.least[axis][block]) this.least[axis][block] = place;
        if (place > this.most[axis][block]) this.most[axis][block] = place;
      });
    });
  }

  /** The smallest box around both paths: its middle and its half sizes. */
  box(exaggeration) {
    if (this.known?.exaggeration !== exaggeration) this.known = { exaggeration, ...this.boxOf(exaggeration) };
    return this.known;
  }

  boxOf(exaggeration) {
    const [middle, half] = [[0, 0, 0], [1, 1, 1]];
    const factor = exaggeration * this.addedUnit;
    for (let axis = 0; axis < 3; axis++) {
      const [at, added] = [this.at[axis], this.added[axis]];
      let [least, most] = [Infinity, -Infinity];
      for (let row = 0; row < this.count; row++) {
        if (this.flags[row] & FLAG.unstated) continue;
        const place = at[row] * this.unit;
        const moved = place + factor * added[row];
        least = Math.min(least, place, moved);
        most = Math.max(most, place, moved);
      }
      this.via.at[axis].forEach((own, number) => {
        const row = this.via.row[number];
        if (this.flags[row] & FLAG.unstated) return;
        const place = own * this.unit;
        const moved = place + factor * added[row];
        least = Math.min(least, place, moved);
        most = Math.max(most, place, moved);
      });
      if (least <= most) [middle[axis], half[axis]] = [(least + most) / 2, (most - least) / 2];
    }
    return { middle, half };
  }

  place(row, exaggeration, out) {
    const factor = exaggeration * this.addedUnit;
    for (let axis = 0; axis < 3; axis++) out[axis] = this.at[axis][row] * this.unit + factor * this.added[axis][row];
    return out;
  }
}

/** One look at the path. A place on the canvas is linear in X, Y, Z. */
class PathView {
  constructor(views, { name, axes, turn }) {
    Object.assign(this, { views, name, axes, turn });
    this.base = make('canvas', {});
    this.top = make('canvas', { tabIndex: 0, role: 'img', 'aria-label': `Path, ${name}` });
    this.top.dataset.view = name;
    this.figure = make('figure', { className: 'view' }, make('figcaption', {}, name), this.base, this.top);
    this.listen();
  }

  /** Rows of the matrix from X, Y, Z to the right and up. */
  rows() {
    if (!this.turn) return this.axes.map(axis => [0, 1, 2].map(other => (other === axis ? 1 : 0)));
    const [ca, sa, ce, se] = [Math.cos(this.turn[0]), Math.sin(this.turn[0]), Math.cos(this.turn[1]), Math.sin(this.turn[1])];
    return [[ca, sa, 0], [-sa * se, ca * se, ce]];
  }

  size() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.figure.clientWidth || 400, this.figure.clientHeight || 300];
    for (const canvas of [this.base, this.top]) {
      if (canvas.width === Math.round(width * ratio) && canvas.height === Math.round(height * ratio)) continue;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    this.figure.style.setProperty('--aspect', `${width} / ${height}`);
    Object.assign(this, { width, height, ratio });
  }

  fit() {
    this.size();
    const { middle, half } = this.path.box(this.views.exaggeration);
    const rows = this.rows();
    this.center = rows.map(row => row.reduce((sum, part, axis) => sum + part * middle[axis], 0));
    const reach = rows.map(row => row.reduce((sum, part, axis) => sum + Math.abs(part) * half[axis], 0));
    const sizes = [this.width / 2 - 26, this.height / 2 - 26];
    this.scale = Math.min(...reach.map((own, k) => sizes[k] / Math.max(own, 1e-3)), 2000);
    this.isFitted = true;
    this.draw();
  }

  /** Numbers that take a place to pixels: x is the first four on X, Y, Z, 1, and y the others. */
  matrix(ratio = 1) {
    const [right, up] = this.rows();
    const s = this.scale * ratio;
    return [
      ...right.map(part => part * s), ratio * this.width / 2 - this.center[0] * s,
      ...up.map(part => -part * s), ratio * this.height / 2 + this.center[1] * s,
    ];
  }

  toScreen([x, y, z], m = this.matrix()) {
    return [m[0] * x + m[1] * y + m[2] * z + m[3], m[4] * x + m[5] * y + m[6] * z + m[7]];
  }

  /** First what is quick, then all of it when nothing else is asked for. */
  draw() {
    this.size();
    const few = theme.printing ? 30000 : 6000;
    const blocks = this.blocksInView();
    const rows = blocks.length * Path.BLOCK;
    for (const _ of this.paint(this.base, blocks, few));
    this.drawTop();
    slices.stop(`view ${this.name}`);
    clearTimeout(this.later);
    if (rows > few && !theme.printing) this.later = setTimeout(() => this.drawAll(blocks, rows), 150);
  }

  /** All rows in view, or, where there are more than can be drawn, the largest of each stretch. */
  drawAll(blocks, rows) {
    const canvas = make('canvas', { width: this.base.width, height: this.base.height });
    slices.start(`view ${this.name}`, this.paint(canvas, blocks, rows <= 200000 ? Infinity : 50000), () => {
      const ctx = this.base.getContext('2d');
      ctx.setTransform(1, 0, 0, 1, 0, 0);
      ctx.clearRect(0, 0, this.base.width, this.base.height);
      ctx.drawImage(canvas, 0, 0);
    });
  }

  blocksInView() {
    const m = this.matrix();
    const { least, most } = this.path;
    const margin = this.views.exaggeration * this.views.largestMm * this.scale + 4;
    const out = [];
    for (let block = 0; block < this.path.blocks; block++) {
      if (least[0][block] > most[0][block]) continue;
      const isInside = (row, size) => {
        let [middle, half] = [m[row + 3], margin];
        for (let axis = 0; axis < 3; axis++) {
          middle += m[row + axis] * (least[axis][block] + most[axis][block]) / 2;
          half += Math.abs(m[row + axis]) * (most[axis][block] - least[axis][block]) / 2;
        }
        return middle + half >= 0 && middle - half <= size;
      };
      if (isInside(0, this.width) && isInside(4, this.height)) out.push(block);
    }
    return out;
  }

  /** Paints the original in gray, then the corrected path in colors; yields now and then. */
  * paint(canvas, blocks, most) {
    const ctx = canvas.getContext('2d');
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    ctx.lineJoin = 'round';
    const stride = Math.max(1, Math.ceil(blocks.length * Path.BLOCK / most));
    for (const exaggeration of [0, this.views.exaggeration]) {
      const pen = new Pen(ctx, this.ratio, exaggeration > 0, this.matrix(this.ratio));
      let before = -2;
      for (let k = 0; k < blocks.length; k++) {
        this.trace(pen, blocks[k], stride, exaggeration, before === blocks[k] - 1);
        before = blocks[k];
        if (pen.segments > 3000) {
          pen.stroke();
          yield;
        }
      }
      pen.stroke();
      yield;
    }
  }

  /** The lines of a block: of each stretch the row with the most added and the last one. */
  trace(pen, block, stride, exaggeration, isNext) {
    const { path } = this;
    const m = pen.matrix;
    const factor = exaggeration * path.addedUnit;
    const [X, Y, Z] = path.at;
    const [dX, dY, dZ] = path.added;
    const first = block * Path.BLOCK;
    const end = Math.min(path.count, first + Path.BLOCK);
    const point = (x, y, z, row, isDrawn) => {
      const [px, py] = [m[0] * x + m[1] * y + m[2] * z + m[3], m[4] * x + m[5] * y + m[6] * z + m[7]];
      const isSeen = isDrawn && !(path.flags[row] & FLAG.unstated);
      if (isSeen) pen.line(px, py, path.classes[row], path.flags[row] & FLAG.rapid); else pen.move(px, py);
    };
    // Within an arc what is added goes over from that of the row before.
    const bend = row => {
      const [start, stop] = [path.viaFrom[row], path.viaFrom[row + 1]];
      for (let k = start; k < stop; k++) {
        const share = (k - start + 1) / (stop - start + 1);
        const place = (axis, added) => {
          return path.via.at[axis][k] * path.unit + factor * (added[row - 1] + share * (added[row] - added[row - 1]));
        };
        point(place(0, dX), place(1, dY), place(2, dZ), row, true);
      }
    };
    let before = -2;
    const go = (row, isDrawn) => {
      if (isDrawn && row > 0 && before === row - 1) bend(row);
      const x = X[row] * path.unit + factor * dX[row];
      const y = Y[row] * path.unit + factor * dY[row];
      const z = Z[row] * path.unit + factor * dZ[row];
      point(x, y, z, row, isDrawn);
      before = row;
    };
    if (isNext) before = first - 1;
    if (!isNext) go(Math.max(0, first - 1), false);
    for (let from = first; from < end; from += stride) {
      const to = Math.min(end, from + stride);
      let largest = to - 1;
      for (let row = from; row < to; row++) if (path.size[row] > path.size[largest]) largest = row;
      const isFirst = from === 0;
      if (largest < to - 1) go(largest, !isFirst);
      go(to - 1, !isFirst || largest < to - 1);
    }
  }

  /** The selected point, the directions, and a bar of length. */
  drawTop() {
    const ctx = this.top.getContext('2d');
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    ctx.clearRect(0, 0, this.width, this.height);
    ctx.font = '11px system-ui, sans-serif';
    this.drawDirections(ctx);
    this.drawBar(ctx);
    const { row } = this.views.app.selected;
    if (row < 0) return;
    const m = this.matrix();
    const [nominal, moved] = [0, this.views.exaggeration].map(factor => this.toScreen(this.path.place(row, factor, []), m));
    ctx.strokeStyle = theme.colors.ink;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(...nominal);
    ctx.lineTo(...moved);
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(...moved, 5, 0, 2 * Math.PI);
    ctx.fillStyle = theme.ramp[this.path.classes[row]];
    ctx.fill();
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(...nominal, 9, 0, 2 * Math.PI);
    ctx.stroke();
  }

  drawDirections(ctx) {
    const [right, up] = this.rows();
    const origin = [26, this.height - 26];
    ctx.lineWidth = 1;
    ctx.strokeStyle = ctx.fillStyle = theme.colors.soft;
    ['X', 'Y', 'Z'].forEach((name, axis) => {
      const [x, y] = [right[axis] * 18, -up[axis] * 18];
      if (Math.hypot(x, y) < 4) return;
      ctx.beginPath();
      ctx.moveTo(...origin);
      ctx.lineTo(origin[0] + x, origin[1] + y);
      ctx.stroke();
      ctx.fillText(name, origin[0] + 1.35 * x - 3, origin[1] + 1.35 * y + 4);
    });
  }

  /** A round length near 80 pixels, on the path and in what was added. */
  drawBar(ctx) {
    const about = 80 / this.scale;
    const power = 10 ** Math.floor(Math.log10(about));
    const length = power * [5, 2, 1].find(part => part * power <= about);
    const right = this.width - 10;
    const y = this.height - 10;
    ctx.strokeStyle = ctx.fillStyle = theme.colors.soft;
    ctx.beginPath();
    for (const [x, from] of [[right - length * this.scale, y - 3], [right, y - 3]]) {
      ctx.moveTo(x, from);
      ctx.lineTo(x, y);
    }
    ctx.moveTo(right - length * this.scale, y);
    ctx.lineTo(right, y);
    ctx.stroke();
    ctx.textAlign = 'right';
    const added = 1000 * length / this.views.exaggeration;
    ctx.fillText(`${plain(length)} mm · added ${plain(added)} µm`, right, y - 7);
    ctx.textAlign = 'left';
  }

  listen() {
    const { top } = this;
    top.addEventListener('pointerdown', event => this.press(event));
    top.addEventListener('pointermove', event => this.drag(event));
    top.addEventListener('pointerup', event => this.release(event));
    top.addEventListener('dblclick', () => this.fit());
    top.addEventListener('wheel', event => {
      event.preventDefault();
      this.zoom(Math.exp(-0.0015 * event.deltaY * (event.deltaMode === 1 ? 30 : 1)), event.offsetX, event.offsetY);
    }, { passive: false });
    top.addEventListener('keydown', event => this.key(event));
    this.redrawSoon = oncePerFrame(() => this.draw());
    this.fitSoon = oncePerFrame(() => this.fit());
  }

  press(event) {
    this.top.setPointerCapture(event.pointerId);
    this.pressed = { x: event.clientX, y: event.clientY, lastX: event.clientX, lastY: event.clientY };
  }

  drag(event) {
    const { pressed } = this;
    if (!pressed) return;
    const [dx, dy] = [event.clientX - pressed.lastX, event.clientY - pressed.lastY];
    [pressed.lastX, pressed.lastY] = [event.clientX, event.clientY];
    if (this.turn && !event.shiftKey) this.rotate(dx, dy); else this.pan(dx, dy);
  }

  release(event) {
    const { pressed } = this;
    this.pressed = null;
    if (pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 4) this.pick(event.offsetX, event.offsetY);
  }

  pan(dx, dy) {
    this.isFitted = false;
    this.center[0] -= dx / this.scale;
    this.center[1] += dy / this.scale;
    this.redrawSoon();
  }

  /** Turns about the middle of the path, which stays where it is. */
  rotate(dx, dy) {
    const { middle } = this.path.box(this.views.exaggeration);
    const before = this.toScreen(middle);
    this.turn = [this.turn[0] - 0.008 * dx, clamp(this.turn[1] + 0.008 * dy, 0, Math.PI / 2)];
    const after = this.toScreen(middle);
    this.pan(before[0] - after[0], before[1] - after[1]);
  }

  zoom(factor, x, y) {
    const scale = clamp(this.scale * factor, 1e-3, 1e5);
    const change = 1 / this.scale - 1 / scale;
    this.center[0] += (x - this.width / 2) * change;
    this.center[1] -= (y - this.height / 2) * change;
    this.scale = scale;
    this.isFitted = false;
    this.redrawSoon();
  }

  key(event) {
    const steps = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] };
    const middle = [this.width / 2, this.height / 2];
    if (steps[event.key]) this.pan(...steps[event.key]);
    else if (event.key === '+' || event.key === '=') this.zoom(1.25, ...middle);
    else if (event.key === '-') this.zoom(0.8, ...middle);
    else if (event.key === '0') this.fit();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** The row of which the line, as it is drawn, is nearest. */
  pick(x, y) {
    const { path } = this;
    const m = this.matrix();
    let [nearest, least] = [-1, 30];
    const place = [0, 0, 0];
    for (const exaggeration of [this.views.exaggeration, 0]) {
      for (const block of this.blocksInView()) {
        const first = block * Path.BLOCK;
        let from = this.toScreen(path.place(Math.max(0, first - 1), exaggeration, place), m);
        for (let row = first; row < Math.min(path.count, first + Path.BLOCK); row++) {
          const to = this.toScreen(path.place(row, exaggeration, place), m);
          const distance = path.flags[row] & FLAG.unstated ? Infinity : distanceToLine(x, y, from, to);
          // Where several rows share a point, the one that ends there is meant.
          if (distance < least - 1e-6) [nearest, least] = [row, distance];
          from = to;
        }
      }
    }
    if (nearest >= 0) this.views.app.selectRow(nearest, 'path');
  }

  /** Brings a row into view. */
  reveal(row) {
    const [x, y] = this.toScreen(this.path.place(row, this.views.exaggeration, []));
    const isInside = x > 12 && x < this.width - 12 && y > 12 && y < this.height - 12;
    if (isInside) this.drawTop(); else this.pan(this.width / 2 - x, this.height / 2 - y);
  }
}

function distanceToLine(x, y, [x0, y0], [x1, y1]) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = dx * dx + dy * dy;
  const part = length > 0 ? clamp(((x - x0) * dx + (y - y0) * dy) / length, 0, 1) : 0;
  return Math.hypot(x - x0 - part * dx, y - y0 - part * dy);
}

/** Up to three digits. */
const plain = value => String(Number(value.toPrecision(3)));

/** Gathers lines by color. What is closer than half a pixel and no larger is left out. */
class Pen {
  constructor(ctx, ratio, isColored, matrix) {
    Object.assign(this, { ctx, ratio, isColored, matrix, x: 0, y: 0, last: 0, segments: 0, paths: new Map() });
  }

  move(x, y) {
    this.x = x;
    this.y = y;
  }

  line(x, y, size, rapid) {
    if (Math.abs(x - this.x) + Math.abs(y - this.y) < 0.5 && size <= this.last) return;
    const key = (this.isColored ? size : 0) + (rapid ? CLASSES : 0);
    let path = this.paths.get(key);
    if (!path) this.paths.set(key, path = new Path2D());
    path.moveTo(this.x, this.y);
    path.lineTo(x, y);
    [this.x, this.y, this.last] = [x, y, size];
    this.segments++;
  }

  /** Rapid moves are thin, and dashed where there are few. */
  stroke() {
    const { ctx, ratio } = this;
    for (const [key, path] of this.paths) {
      const isRapid = key >= CLASSES;
      ctx.strokeStyle = this.isColored ? theme.ramp[key % CLASSES] : theme.colors.soft;
      ctx.globalAlpha = this.isColored ? (isRapid ? 0.7 : 1) : 0.55;
      ctx.lineWidth = ratio * (isRapid ? 0.7 : this.isColored ? 1.4 : 1);
      ctx.setLineDash(isRapid && this.segments < 1500 ? [5 * ratio, 4 * ratio] : []);
      ctx.stroke(path);
    }
    ctx.globalAlpha = 1;
    this.paths.clear();
    this.segments = 0;
  }
}

/** Four looks at the path, and what they share. */
class PathViews {
  constructor(app) {
    this.app = app;
    this.exaggeration = 1000;
    this.largestMm = app.review.largest * app.review.step * MM_PER_UM;
    byId('path-controls').append(...this.controls());
    const half = Math.PI / 180;
    this.views = [
      { name: 'XY', axes: [0, 1] }, { name: 'XZ', axes: [0, 2] },
      { name: 'YZ', axes: [1, 2] }, { name: '3D', turn: [35 * half, 30 * half] },
    ].map(own => new PathView(this, own));
    byId('path-views').append(...this.views.map(view => view.figure));
    // Drawn when it comes into sight: the page opens at its verdict.
    const seen = new IntersectionObserver(entries => {
      if (this.isDrawn || !entries.some(entry => entry.isIntersecting)) return;
      this.start();
    }, { rootMargin: '400px' });
    seen.observe(byId('path-views'));
    const resized = oncePerFrame(() => this.redraw());
    const isOther = ({ figure, width }) => figure.clientWidth !== width;
    new ResizeObserver(() => { if (this.isDrawn && isOther(this.views[0])) resized(); }).observe(byId('path-views'));
  }

  /** The path in blocks, and the views fitted to it. */
  start() {
    if (this.isDrawn) return;
    this.isDrawn = true;
    this.path = new Path(this.app.review);
    this.views.forEach(view => { view.path = this.path; view.fit(); });
  }

  controls() {
    this.shown = make('output', {}, '×1,000');
    const slider = make('input', { type: 'range', min: 2, max: 4, step: 0.05, value: 3, id: 'exaggeration' });
    slider.addEventListener('input', () => this.exaggerate(Number(slider.value)));
    const label = make('label', {}, make('span', {}, 'exaggeration'), slider, this.shown);
    this.swatches = RAMPS.light.map(() => make('i', {}));
    const { palest, largest, step } = this.app.review;
    const [from, to] = [palest > 0 ? `≤ ${(palest * step).toFixed(1)}` : '0', `${(largest * step).toFixed(1)} ${UNIT[this.app.review.unit]}`];
    const legend = make('span', { className: 'legend' }, from, make('span', { className: 'ramp' }, ...this.swatches), to);
    this.colorLegend();
    const fit = button('Fit', 'The whole path in all views (double-click in one)', () => {
      this.start();
      this.views.forEach(view => view.fit());
    });
    const hint = 'gray: original, colored: corrected; drag pans (3D: turns, with Shift pans), wheel zooms, click selects';
    return [label, legend, fit, make('span', { className: 'hint' }, hint)];
  }

  colorLegend() {
    this.swatches.forEach((swatch, number) => { swatch.style.background = theme.ramp[number]; });
  }

  /** Views that nobody has moved stay fitted. */
  exaggerate(power) {
    this.exaggeration = 10 ** power;
    this.shown.textContent = `×${grouped(Number(this.exaggeration.toPrecision(2)))}`;
    if (this.isDrawn) this.views.forEach(view => (view.isFitted ? view.fitSoon() : view.redrawSoon()));
  }

  select({ row }) {
    if (!this.isDrawn) return;
    const isPlaced = row >= 0 && !(this.app.review.flags[row] & FLAG.unstated);
    this.views.forEach(view => { if (isPlaced) view.reveal(row); else view.drawTop(); });
  }

  redraw() {
    this.start();
    this.colorLegend();
    this.views.forEach(view => (view.isFitted ? view.fit() : view.draw()));
  }

  print() { this.redraw(); }
}

// ---------------------------------------------------------------- filters

/** Which lines are shown, and which rows count as the largest. */
class Filters {
  constructor(app) {
    this.app = app;
    this.threshold = 0;
    this.rows = null;
    this.items = null;
    this.found = null;
    byId('filters').append(...this.controls());
    this.tell();
  }

  controls() {
    const { review } = this.app;
    const changed = () => this.apply();
    const axes = [['', 'all'], ...review.axes.map(({ name }, number) => [number, name])];
    this.axis = choice('axis', axes, changed);
    this.axis.select.id = 'filter-axis';
    this.least = make('input', { type: 'number', min: 0, step: 'any', id: 'filter-threshold', placeholder: '0' });
    this.least.addEventListener('input', changed);
    this.unit = make('span', {}, UNIT[review.unit]);
    const tools = [['', 'all'], ...review.toolNames.map((name, number) => [number, name || 'none']).slice(1)];
    this.toolChoice = choice('tool', tools, changed);
    this.toolChoice.select.id = 'filter-tool';
    this.kind = choice('moves', [['', 'all'], ['feed', 'feed'], ['rapid', 'rapid']], changed);
    this.kind.select.id = 'filter-kind';
    this.search = make('input', { type: 'search', id: 'filter-text', placeholder: 'text', 'aria-label': 'Lines with this text' });
    let later;
    this.search.addEventListener('input', () => { clearTimeout(later); later = setTimeout(() => this.find(), 200); });
    this.count = make('output', { id: 'count', 'aria-live': 'polite' });
    return [
      this.axis.label, make('label', {}, make('span', {}, 'at least'), this.least, this.unit), this.toolChoice.label, this.kind.label,
      this.tick('split', 'in several pieces'), this.tick('alone', 'left alone'), this.search,
      button('Clear', 'All lines', () => this.clear()),
      button('▲ larger (p)', 'The next larger deviation (p)', () => this.app.goLargest(-1)),
      button('▼ next largest (n)', 'The largest deviation, then the next smaller (n)', () => this.app.goLargest(1)),
      this.count,
    ];
  }

  tick(name, text) {
    this[name] = make('input', { type: 'checkbox', id: `filter-${name}` });
    this[name].addEventListener('change', () => this.apply());
    return make('label', { className: 'toggle' }, this[name], text);
  }

  clear() {
    for (const { select } of [this.axis, this.toolChoice, this.kind]) select.value = '';
    this.least.value = this.search.value = '';
    this.split.checked = this.alone.checked = false;
    slices.stop('search');
    this.found = null;
    this.apply();
  }

  /** Lines with a text, found in slices. */
  find() {
    const wanted = this.search.value.toLowerCase();
    slices.stop('search');
    this.found = null;
    if (wanted === '') return this.apply();
    this.count.textContent = 'searching …';
    slices.start('search', this.searching(wanted), found => {
      this.found = found;
      this.apply();
    });
  }

  * searching(wanted) {
    const { review } = this.app;
    const found = new Uint8Array(review.items);
    const has = (text, line) => text.put(line).toLowerCase().includes(wanted);
    for (let item = 0; item < review.items; item++) {
      const line = review.itemCorrected[item];
      const original = review.originalOf(item);
      found[item] = (line > 0 && has(review.text, line)) || (original !== null && has(original.text, original.line)) ? 1 : 0;
      if (item % 200 === 0) {
        if (item % 50000 === 0) this.count.textContent = `searching … ${Math.round(100 * item / review.items)} %`;
        yield;
      }
    }
    return found;
  }

  apply() {
    this.threshold = Math.max(0, Number(this.least.value) || 0);
    const { review } = this.app;
    const axis = this.axis.select.value;
    this.unit.textContent = UNIT[axis === '' ? review.unit : review.axes[Number(axis)].unit];
    this.sizes = axis === '' ? review.size : review.added[Number(axis)].map(Math.abs);
    this.rows = this.rowsThatPass(review);
    this.items = this.itemsThatPass(review);
    this.order = null;
    this.tell();
    this.app.filtered();
  }

  rowsThatPass(review) {
    const least = Math.round(this.threshold / review.step);
    const [tool, kind] = [this.toolChoice.select.value, this.kind.select.value];
    const tests = [];
    if (least > 0) tests.push(row => this.sizes[row] >= least);
    else if (this.axis.select.value !== '') tests.push(row => this.sizes[row] > 0);
    if (tool !== '') tests.push(row => review.tool[row] === Number(tool));
    if (kind !== '') tests.push(row => ((review.flags[row] & FLAG.rapid) !== 0) === (kind === 'rapid'));
    if (this.split.checked) tests.push(row => review.split[row] === 1);
    if (this.alone.checked) tests.push(row => review.alone[row] === 1);
    if (tests.length === 0) return null;
    return Uint8Array.from({ length: review.count }, (_, row) => (tests.every(test => test(row)) ? 1 : 0));
  }

  /** A line is shown where one of its rows passes; comments have none. */
  itemsThatPass(review) {
    const { rows, found } = this;
    if (!rows && !found) return null;
    const lines = new Uint8Array(review.pair.length + 1).fill(rows ? 0 : 1);
    if (rows) rows.forEach((passes, row) => { if (passes) lines[review.corrected[row]] = 1; });
    const out = new Uint32Array(review.items);
    let count = 0;
    for (let item = 0; item < review.items; item++) {
      const line = review.itemCorrected[item];
      const passes = line > 0 ? lines[line] === 1 : !rows;
      if (passes && (!found || found[item])) out[count++] = item;
    }
    return out.slice(0, count);
  }

  shown() { return this.items ? this.items.length : this.app.review.items; }
  itemAt(place) { return this.items ? this.items[place] : place; }
  /** Where an item is among those shown, or where it would be. */
  placeOf(item) { return this.items ? firstNotBelow(this.items, item) : item; }

  largest() {
    this.order ??= new Order(this.sizes ?? this.app.review.size, this.rows);
    return this.order;
  }

  tell() { this.count.textContent = `${grouped(this.shown())} of ${grouped(this.app.review.items)} lines`; }
}

// ---------------------------------------------------------------- the list of lines

/** Digits of a number that are others than before, at the same decimal place; what is not written is 0. */
function changedDigits(before, after) {
  if (before === after) return [];
  if (before.startsWith('-') !== after.startsWith('-')) return [[0, after.length]];
  const [whole, part = ''] = before.split('.');
  const point = after.includes('.') ? after.indexOf('.') : after.length;
  const out = [];
  for (let at = 0; at < after.length; at++) {
    if (!/\d/.test(after[at])) continue;
    const back = whole.length - (point - at);
    const old = at < point ? (back < 0 || whole[back] === '-' ? '0' : whole[back]) : part[at - point - 1] ?? '0';
    if (old !== after[at]) out.push([at, at + 1]);
  }
  return out;
}

/** Where the text of a corrected line differs: in digits of numbers, and in words that the original has not. */
function marksOf(original, corrected) {
  const before = new Map();
  for (const number of original.numbers) {
    if (!before.has(number.letter)) before.set(number.letter, []);
    before.get(number.letter).push(number.text);
  }
  const marks = [];
  for (const { letter, start, text } of corrected.numbers) {
    const old = before.get(letter)?.shift();
    if (old === undefined) marks.push([start, start + text.length, 'new']);
    else changedDigits(old, text).forEach(([from, to]) => marks.push([start + from, start + to, 'changed']));
  }
  return marks;
}

/** Fills an element with a text, of which some stretches are marked. */
function putMarked(element, text, marks) {
  const parts = [];
  let done = 0;
  for (const [from, to, className] of marks) {
    if (from >= text.length) break;
    if (from > done) parts.push(text.slice(done, from));
    parts.push(make('span', { className }, text.slice(from, to)));
    done = Math.min(to, text.length);
  }
  if (done < text.length) parts.push(text.slice(done));
  element.replaceChildren(...parts);
}

/** All lines side by side. Only those in sight are elements. */
class LineList {
  static HEIGHT = 20;
  /** Browsers do not scroll further than about this. */
  static TALLEST = 6e6;
  /** Characters of a line in the list. */
  static CUT = 200;

  constructor(app) {
    this.app = app;
    this.place = byId('lines');
    this.top = 0;
    this.build();
    this.listen();
    this.refresh();
    new ResizeObserver(oncePerFrame(() => this.refresh())).observe(this.scroller);
  }

  build() {
    const { review } = this.app;
    this.place.setAttribute('role', 'listbox');
    this.place.setAttribute('aria-label', 'Lines of the original and of the corrected program');
    byId('list').style.setProperty('--axes', Math.max(1, review.axes.length));
    const axes = review.axes.map(({ name, unit }) => make('span', { className: 'n' }, `${name}, ${UNIT[unit] ?? unit}`));
    const line = () => make('span', { className: 'n' }, 'line');
    const name = program => make('span', {}, baseName(program.name));
    const titles = [line(), name(review.original), make('span', {}), line(), name(review.text), ...axes];
    this.head = make('div', { className: 'row head' }, ...titles);
    this.layer = make('div', { className: 'layer' });
    this.spacer = make('div', { className: 'spacer' }, this.layer);
    this.scroller = make('div', { className: 'scroller' }, this.spacer);
    this.map = make('canvas', { className: 'minimap', title: 'Where deviations are' });
    this.none = make('p', { className: 'none' }, 'No line passes the filter.');
    this.place.append(this.head, this.scroller, this.map, this.none);
    this.detail = make('div', { id: 'line-detail', 'aria-live': 'polite' });
    this.printed = make('div', { className: 'printed' });
    const help = 'j k or ↓ ↑ line · n p by falling deviation · f filter · Home End PgUp PgDn in the list · '
      + 'Enter whole line · Esc nothing selected';
    this.place.after(this.detail, make('p', { className: 'help' }, help), this.printed);
    this.rows = [];
  }

  // The range that is scrolled may be taller than a browser allows; `top` is where the list is, in pixels as if it were not.
  tall() { return this.app.filters.shown() * LineList.HEIGHT; }
  height() { return this.seen; }
  lastTop() { return Math.max(0, this.tall() - this.height()); }
  shrink() { return (Math.min(this.tall(), LineList.TALLEST) - this.height()) / Math.max(1, this.lastTop()); }

  listen() {
    const { scroller, place } = this;
    this.drawSoon = oncePerFrame(() => this.draw());
    scroller.addEventListener('scroll', () => {
      if (Math.abs(scroller.scrollTop - this.asked) < 1) return;
      this.top = clamp(scroller.scrollTop / Math.max(this.shrink(), 1e-9), 0, this.lastTop());
      this.asked = scroller.scrollTop;
      this.drawSoon();
    });
    scroller.addEventListener('wheel', event => {
      const isWhole = this.tall() <= LineList.TALLEST;
      if (isWhole || event.ctrlKey) return;
      event.preventDefault();
      this.scrollTo(this.top + event.deltaY * (event.deltaMode === 1 ? LineList.HEIGHT : 1));
    }, { passive: false });
    scroller.addEventListener('click', event => {
      const place = Math.floor((event.clientY - scroller.getBoundingClientRect().top + this.top) / LineList.HEIGHT);
      if (place < this.app.filters.shown()) this.app.selectItem(this.app.filters.itemAt(place), 'list');
    });
    place.addEventListener('keydown', event => this.key(event));
    this.listenToMap();
  }

  listenToMap() {
    const go = event => {
      const box = this.map.getBoundingClientRect();
      this.scrollTo((event.clientY - box.top) / box.height * this.tall() - this.height() / 2);
    };
    this.map.addEventListener('pointerdown', event => { this.map.setPointerCapture(event.pointerId); go(event); });
    this.map.addEventListener('pointermove', event => { if (event.buttons & 1) go(event); });
  }

  key(event) {
    const page = Math.max(1, Math.floor(this.height() / LineList.HEIGHT) - 1);
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === 'Enter') this.showDetail(true);
    else if (steps[event.key]) this.app.goLine(steps[event.key]);
    else return;
    event.preventDefault();
  }

  scrollTo(top) {
    this.top = clamp(top, 0, this.lastTop());
    this.scroller.scrollTop = this.top * this.shrink();
    this.asked = this.scroller.scrollTop;
    this.drawSoon();
  }

  /** Brings an item into sight, in the middle if it comes from elsewhere. */
  reveal(item, isNear) {
    const { HEIGHT } = LineList;
    const top = this.app.filters.placeOf(item) * HEIGHT;
    if (top >= this.top && top + HEIGHT <= this.top + this.height()) return;
    if (isNear) this.scrollTo(top < this.top ? top : top + HEIGHT - this.height());
    else this.scrollTo(top - this.height() / 2);
  }

  /** After the filter or the size has changed. */
  refresh() {
    this.seen = this.scroller.clientHeight || 500;
    this.spacer.style.height = `${Math.min(this.tall(), LineList.TALLEST)}px`;
    this.none.hidden = this.tall() > 0;
    this.scrollTo(this.top);
    this.draw();
    slices.start('map', this.measureMap());
  }

  draw() {
    const { HEIGHT } = LineList;
    const { filters } = this.app;
    const first = Math.floor(this.top / HEIGHT);
    const count = Math.min(Math.ceil(this.height() / HEIGHT) + 1, filters.shown() - first);
    // The first that is to be seen whole.
    const whole = this.top - first * HEIGHT > 1 ? 1 : 0;
    while (this.rows.length < count) this.addRow();
    this.rows.forEach((row, k) => {
      row.element.hidden = k >= count;
      if (k < count) this.fill(row, filters.itemAt(first + k), k === whole || this.isOther(first + k));
    });
    this.layer.style.transform = `translateY(${first * HEIGHT - this.top}px)`;
    this.drawWindow();
  }

  /** Whether the line above, of those that are shown, comes from another line of the original. */
  isOther(place) {
    const [above, own] = [place - 1, place].map(at => this.app.review.itemOriginal[this.app.filters.itemAt(at)]);
    return place === 0 || above !== own;
  }

  addRow() {
    const row = this.newRow();
    this.layer.append(row.element);
    this.rows.push(row);
  }

  newRow() {
    const cell = className => make('span', { className });
    const axes = this.app.review.axes.map(() => cell('n added'));
    const row = { cells: [cell('n number'), cell('text'), cell('badge'), cell('n number'), cell('text'), ...axes] };
    row.element = make('div', { className: 'row', role: 'option' }, ...row.cells);
    return row;
  }

  /** `isNamed`: the first piece in sight has the text of the original, though others are before it. */
  fill({ element, cells }, item, isNamed) {
    const { review, selected } = this.app;
    const line = review.itemCorrected[item];
    const original = review.originalOf(item);
    const group = review.group(item);
    const before = original && original.text.parts(original.line);
    const after = line > 0 ? review.text.parts(line) : null;
    const isLast = group.place === group.count - 1;
    const isTold = group.place === 0 || isNamed;
    cells[0].textContent = original && isTold ? (original.file > 0 ? '↳' : '') + grouped(original.line) : '';
    cells[0].title = original && original.file > 0 ? original.text.name : '';
    putCut(cells[1], before && isTold ? before.text : '', []);
    this.fillBadge(cells[2], { original, line, group });
    cells[3].textContent = line > 0 ? grouped(line) : '';
    putCut(cells[4], after ? after.text : '', after && before && isLast ? marksOf(before, after) : []);
    this.fillAdded(cells, item);
    const isSelected = selected.item === item;
    const kinds = [
      ['selected', isSelected], ['dropped', !line], ['inserted', !original], ['piece', group.count > 1], ['again', group.place > 0],
    ];
    element.className = ['row', ...kinds.filter(([, is]) => is).map(([name]) => name)].join(' ');
    element.setAttribute('aria-selected', String(isSelected));
    element.id = isSelected ? 'selected-line' : '';
  }

  fillBadge(cell, { original, line, group }) {
    const times = line > 0 ? this.app.review.timesOf[line] : 0;
    cell.title = '';
    if (group.count > 1 && group.place === 0) cell.textContent = `1:${group.count}`;
    else if (group.count > 1) cell.textContent = group.place === group.count - 1 ? '└' : '│';
    else if (!line) cell.textContent = '−';
    else if (!original) cell.textContent = '+';
    else cell.textContent = times > 1 ? `×${times}` : '';
    if (times > 1) cell.title = `executed as ${times} pieces; the largest is shown`;
  }

  fillAdded(cells, item) {
    const { review, selected } = this.app;
    const row = selected.item === item && selected.row >= 0 ? selected.row : review.rowOfItem(item);
    review.added.forEach((values, number) => {
      const value = row < 0 ? null : values[row];
      const cell = cells[5 + number];
      cell.textContent = value === null ? '' : signed(value * review.axes[number].scale, 2);
      cell.classList.toggle('zero', value === 0);
    });
  }

  /** For each pixel of the strip the largest of the lines there. */
  * measureMap() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(14 * ratio), Math.max(1, Math.round(this.height() * ratio))];
    const { filters, review } = this.app;
    const rowSizes = filters.sizes ?? review.size;
    const count = filters.shown();
    const sizes = new Int32Array(height).fill(-1);
    for (let place = 0; place < count; place++) {
      if (place % 20000 === 0) yield;
      const row = review.rowOfItem(filters.itemAt(place));
      if (row < 0) continue;
      const from = Math.floor(place * height / count);
      const to = Math.max(from + 1, Math.floor((place + 1) * height / count));
      for (let y = from; y < to; y++) sizes[y] = Math.max(sizes[y], rowSizes[row]);
    }
    this.mapSizes = sizes;
    Object.assign(this.map, { width, height });
    this.drawWindow();
  }

  drawWindow() {
    if (!this.mapSizes) return;
    const ctx = this.map.getContext('2d');
    const { width, height } = this.map;
    ctx.clearRect(0, 0, width, height);
    const largest = Math.max(1, this.app.review.largest);
    this.mapSizes.forEach((size, y) => {
      if (size <= 0) return;
      ctx.fillStyle = theme.ramp[this.app.review.colorClass(size)];
      ctx.fillRect(0, y, Math.max(2, width * size / largest), 1);
    });
    const tall = Math.max(1, this.tall());
    ctx.strokeStyle = theme.colors.ink;
    ctx.strokeRect(0.5, height * this.top / tall + 0.5, width - 1, Math.max(3, height * this.height() / tall) - 1);
    const { item } = this.app.selected;
    if (item < 0) return;
    ctx.fillStyle = theme.colors.bad;
    ctx.fillRect(0, height * this.app.filters.placeOf(item) * LineList.HEIGHT / tall - 1, width, 2);
  }

  select({ item }, from) {
    if (item >= 0) this.reveal(item, from === 'step');
    this.draw();
    this.place.setAttribute('aria-activedescendant', item >= 0 ? 'selected-line' : '');
    this.showDetail(false);
  }

  /** The selected line whole, and what is known of it. */
  showDetail(isWhole) {
    const { review, selected: { item, row } } = this.app;
    this.detail.replaceChildren();
    if (item < 0) return;
    const original = review.originalOf(item);
    const line = review.itemCorrected[item];
    const parts = [];
    if (original) parts.push(this.wholeLine(original.text, original.line, isWhole));
    if (line > 0) parts.push(this.wholeLine(review.text, line, isWhole));
    if (row >= 0) parts.push(make('p', {}, factsOf(review, row)));
    this.detail.append(...parts);
  }

  wholeLine(program, line, isWhole) {
    const most = 400;
    const text = program.put(line);
    const code = make('code', {}, isWhole ? text : text.slice(0, most));
    const out = make('div', { className: 'whole' }, make('span', {}, `${baseName(program.name)} ${grouped(line)}`), code);
    const all = `… all ${grouped(text.length)} characters`;
    if (!isWhole && text.length > most) out.append(button(all, '', () => this.showDetail(true)));
    return out;
  }

  redraw() { this.draw(); }

  filter() {
    const { item } = this.app.selected;
    this.top = 0;
    this.refresh();
    if (item >= 0) this.reveal(item, false);
  }

  /** On paper the first lines, with how many there are. */
  print(isPrinting) {
    const most = 40;
    this.printed.replaceChildren();
    if (!isPrinting) return;
    const { filters } = this.app;
    const count = Math.min(most, filters.shown());
    this.printed.append(this.head.cloneNode(true));
    for (let place = 0; place < count; place++) {
      const row = this.newRow();
      this.fill(row, filters.itemAt(place), this.isOther(place));
      row.element.removeAttribute('id');
      this.printed.append(row.element);
    }
    const note = `The first ${most} of ${grouped(filters.shown())} lines; the others are in the page.`;
    if (filters.shown() > most) this.printed.append(make('p', {}, note));
  }
}

/** A text in a cell: of long lines the beginning. */
function putCut(cell, text, marks) {
  const { CUT } = LineList;
  const isLong = text.length > CUT;
  putMarked(cell, isLong ? text.slice(0, CUT) : text, marks);
  if (isLong) cell.append(make('span', { className: 'cut' }, ` … ${grouped(text.length)} characters`));
}

/** What is known of a row, in words. */
function factsOf(review, row) {
  const flags = review.flags[row];
  const [x, y, z] = review.at.map(places => (places[row] * review.header.position_mm).toFixed(3));
  const tool = review.toolNames[review.tool[row]];
  const facts = [
    `piece ${grouped(row + 1)} of ${grouped(review.count)}`, flags & FLAG.rapid ? 'rapid' : 'feed',
    tool ? `tool ${tool}` : 'no tool',
    flags & FLAG.unstated ? 'the program has not stated where the axes are' : `nominal X ${x}  Y ${y}  Z ${z} mm`,
  ];
  if (flags & FLAG.spot) facts.push('correction only');
  if (flags & FLAG.feed) facts.push('with another feed than its move');
  return facts.join(' · ');
}

// ---------------------------------------------------------------- temperatures and corrections of a transfer

/** Times of a transfer that was taken up again may begin anew: they go on from where they were. */
function onward(times) {
  const out = Float64Array.from(times);
  let before = 0;
  for (let place = 1; place < out.length; place++) {
    if (times[place] < times[place - 1]) before += times[place - 1];
    out[place] += before;
  }
  return out;
}

function journalPlots(header, streams) {
  const { journal } = header;
  const place = byId('journal-plots');
  const times = streams.get('journal.t') ?? [];
  if (!journal || !place || times.length === 0) return [];
  const isLong = times[times.length - 1] > 6e5;
  const x = onward(times).map(time => time / (isLong ? 6e4 : 1e3));
  const xLabel = () => `time, ${isLong ? 'min' : 's'}`;
  const sensors = journal.sensors.map((name, number) => (
    { name, color: number, scale: 1e-3, values: streams.get(`journal.sensor.${number}`) }
  ));
  const offsets = journal.axes.flatMap((name, number) => [
    { name: `${name} asked for`, color: number, scale: 0.01, dash: [4, 4], values: streams.get(`journal.axis.${name}.target`) },
    { name: `${name} applied`, color: number, scale: 0.01, values: streams.get(`journal.axis.${name}.applied`) },
  ]);
  const waiting = journal.waiting.map((name, number) => (
    { name: `lines ${name}`, color: number, scale: 1, values: streams.get(`journal.waiting.${number}`) }
  ));
  const draw = (columns, yLabel, label) => {
    const known = columns.filter(({ values }) => values);
    if (known.length === 0) return [];
    const own = make('div', {});
    let plot;
    const toggles = known.map(({ name, color, dash }, number) =>
      lineToggle(name, color, isShown => plot.show(number, isShown), dash !== undefined));
    place.append(make('div', { className: 'controls' }, ...toggles), own);
    plot = new LinePlot(own, { x, columns: known, xLabel, yLabel, height: 220, label });
    return [plot];
  };
  return [
    ...draw(sensors, '°C', 'Temperatures over time'),
    ...draw(offsets, 'µm', 'Corrections over time, requested and applied'),
    ...draw(waiting, 'lines', 'Fill of the buffer over time'),
  ];
}

// ---------------------------------------------------------------- sign-off

/** What the form says, with what it is about. */
function signOff(form, object, figures) {
  const value = name => form.elements[name]?.value ?? '';
  return {
    name: value('name'), decision: value('decision'), remarks: value('remarks'), time: new Date().toISOString(),
    files: object.files, provenance: object.provenance, verdict: object.verdict, moves: object.moves,
    changed: object.changed, axes: figures,
  };
}

function listenToSignOff(object, figures, corrected) {
  const form = byId('signoff-form');
  if (!form) return;
  form.addEventListener('submit', event => event.preventDefault());
  byId('signoff-print')?.addEventListener('click', () => window.print());
  byId('signoff-save')?.addEventListener('click', () => {
    const text = `${JSON.stringify(signOff(form, object, figures), null, 2)}\n`;
    const url = URL.createObjectURL(new Blob([text], { type: 'application/json' }));
    make('a', { href: url, download: `${baseName(corrected)}.signoff.json` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
  });
}

// ---------------------------------------------------------------- all together

/** What is selected, and who wants to know. */
class App {
  constructor(review) {
    this.review = review;
    this.selected = { row: -1, item: -1 };
    this.parts = [];
    this.filters = new Filters(this);
    this.deviation = new DeviationPlot(this);
    this.path = new PathViews(this);
    this.list = new LineList(this);
    this.parts = [this.deviation, this.path, this.list];
  }

  select(row, item, from) {
    this.selected = { row, item };
    this.parts.forEach(part => part.select(this.selected, from));
    this.tell();
  }

  selectRow(row, from) {
    if (row >= 0) this.select(row, this.review.itemOf[this.review.corrected[row]], from);
  }

  selectItem(item, from) { this.select(this.review.rowOfItem(item), item, from); }
  clear() { this.select(-1, -1); }

  /** To the line so many places on, of those that are shown. */
  goLine(places) {
    const count = this.filters.shown();
    if (count === 0) return;
    const { item } = this.selected;
    const at = item < 0 ? (places > 0 ? -1 : count) : this.filters.placeOf(item);
    const isThere = item < 0 || this.filters.itemAt(at) === item;
    const place = clamp(at + places + (isThere || places < 0 ? 0 : -1), 0, count - 1);
    this.selectItem(this.filters.itemAt(place), 'step');
  }

  goLargest(places) { this.selectRow(this.filters.largest().beside(this.selected.row, places), 'largest'); }

  filtered() {
    this.parts.forEach(part => part.filter?.());
    this.tell();
  }

  redraw() {
    theme.read();
    this.parts.forEach(part => part.redraw());
  }

  print(isPrinting) {
    theme.printing = isPrinting;
    theme.read();
    this.parts.forEach(part => part.print(isPrinting));
    const remarks = document.querySelector('#signoff-form textarea');
    if (remarks) remarks.style.height = isPrinting ? `${remarks.scrollHeight + 4}px` : '';
  }

  /** What scripts can read. */
  tell() {
    const { row, item } = this.selected;
    const { review } = this;
    const own = window.__ncfix ?? {};
    own.shown = this.filters.shown();
    own.selected = item < 0 ? null : { row, line: review.originalOf(item)?.line ?? 0, corrected: review.itemCorrected[item] };
    return own;
  }
}

/** Letters work everywhere but where one types; other keys belong to what has the focus. */
function listenToKeys(app) {
  const isTyping = ({ tagName, type }) => ['TEXTAREA', 'SELECT'].includes(tagName)
    || (tagName === 'INPUT' && !['range', 'checkbox'].includes(type));
  const keys = {
    j: () => app.goLine(1), k: () => app.goLine(-1), n: () => app.goLargest(1), p: () => app.goLargest(-1),
    f: () => app.filters.least.focus(), Escape: () => app.clear(),
  };
  document.addEventListener('keydown', event => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (isTyping(event.target)) {
      if (event.key === 'Escape') event.target.blur();
      return;
    }
    const isFree = event.target === document.body;
    const arrow = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (keys[event.key]) keys[event.key]();
    else if (arrow && isFree && app.selected.item >= 0) app.goLine(arrow);
    else return;
    event.preventDefault();
  });
}

async function open() {
  const object = JSON.parse(byId('review').textContent);
  const { header, streams } = await unpack(byId('data').textContent);
  theme.read();
  const review = new Review({ header, streams });
  const figures = Object.fromEntries(review.axes.map(({ name, scale }, number) =>
    [name, figuresOf(review.added[number], review.line, scale)]));
  const app = new App(review);
  app.parts.push(...journalPlots(header, streams).map(plot => ({
    select() {}, redraw: () => plot.redraw(), print: () => plot.print(),
  })));
  listenToKeys(app);
  listenToSignOff(object, figures, header.corrected.name);
  darkScheme.addEventListener('change', () => app.redraw());
  window.addEventListener('beforeprint', () => app.print(true));
  window.addEventListener('afterprint', () => app.print(false));
  window.__ncfix = Object.assign(app.tell(), { rows: review.count, axes: figures });
  // Sorted when asked for: a million rows take a moment.
  const largest = () => Array.from(app.filters.largest().rows.subarray(0, 100));
  Object.defineProperties(window.__ncfix, {
    largest: { enumerable: true, get: largest },
    marker: { enumerable: true, get: () => app.deviation.markerLeft() },
  });
  await new Promise(done => { requestAnimationFrame(() => setTimeout(done)); });
  Object.assign(window.__ncfix, { ready: true, opened_ms: performance.now() });
}

open().catch(error => {
  // The figures above are there without a script: what cannot be shown is said, not hidden.
  byId('deviation-plot').textContent = `The data of this page cannot be shown: ${error.message}`;
  window.__ncfix = { ready: false, error: String(error.stack ?? error) };
});
})();
