/** Rows kept for the plots, never more than a fixed number. Pure: no page, no clock. */

/** The last rows by columns: at least `capacity` of them once so many came, and never more than twice as many.

Their place is taken at once, so that a page that stays open does not grow. A value that is missing is kept as NaN and
given as null, which is what plots and texts take for a gap. */
export class LastRows {
  constructor(width, capacity) {
    this.capacity = capacity;
    this.kept = Array.from({ length: width }, () => new Float64Array(2 * capacity));
    this.length = 0;
    this.forgotten = false;
  }

  /** Append a row; when twice the capacity is there, the older half goes. */
  push(row) {
    if (this.length === 2 * this.capacity) this.dropOlder();
    this.kept.forEach((column, place) => { column[this.length] = row[place] ?? NaN; });
    this.length += 1;
  }

  dropOlder() {
    for (const column of this.kept) column.copyWithin(0, this.capacity);
    this.length = this.capacity;
    this.forgotten = true;
  }

  clear() {
    this.length = 0;
    this.forgotten = false;
  }

  /** Return a value; null if it is missing. */
  value(place, row) {
    const value = this.kept[place][row];
    return row < 0 || row >= this.length || Number.isNaN(value) ? null : value;
  }

  /** Return the value of a column in the newest row, or null. */
  last(place) {
    return this.value(place, this.length - 1);
  }

  /** Return a column from a row on, with null for a missing value. */
  column(place, from = 0) {
    const kept = this.kept[place];
    const column = new Array(this.length - from);
    for (let row = from; row < this.length; row += 1) column[row - from] = Number.isNaN(kept[row]) ? null : kept[row];
    return column;
  }

  /** Return the first row that is not earlier than a time; column 0 is the time and only grows. */
  firstFrom(time_s) {
    return firstAtLeast(this.kept[0].subarray(0, this.length), time_s);
  }
}

/** The envelope of rows: of each interval of time the least and the greatest value of each column, as two rows. */
export class Envelope {
  constructor(width, capacity, spacing_s) {
    this.rows = new LastRows(width, capacity);
    this.spacing_s = spacing_s;
    this.interval = null;
    this.least = new Array(width).fill(null);
    this.greatest = new Array(width).fill(null);
  }

  /** Take a row in; its column 0 is its time [s]. */
  push(row) {
    const interval = Math.floor(row[0] / this.spacing_s);
    if (this.interval !== null && interval !== this.interval) this.close();
    if (this.interval === null) this.begin(interval, row);
    else this.widen(row);
  }

  begin(interval, row) {
    this.interval = interval;
    for (let place = 0; place < row.length; place += 1) this.least[place] = this.greatest[place] = row[place];
  }

  widen(row) {
    for (let place = 0; place < row.length; place += 1) {
      const value = row[place];
      if (value === null) continue;
      if (this.least[place] === null || value < this.least[place]) this.least[place] = value;
      if (this.greatest[place] === null || value > this.greatest[place]) this.greatest[place] = value;
    }
  }

  close() {
    this.rows.push(this.least);
    if (this.greatest[0] > this.least[0]) this.rows.push(this.greatest);
    this.interval = null;
  }

  clear() {
    this.rows.clear();
    this.interval = null;
  }
}

/** What the plots draw: all rows while they reach back far enough, else their envelope. */
export class History {
  constructor(width, { capacity = 6000, longest_s = 600 } = {}) {
    this.recent = new LastRows(width, capacity);
    this.envelope = new Envelope(width, 2400, longest_s / 1200);
  }

  push(row) {
    const before = this.recent.last(0);
    if (before !== null && row[0] < before) this.clear(); // the rig was switched on again: its clock began again
    this.recent.push(row);
    this.envelope.push(row);
  }

  clear() {
    this.recent.clear();
    this.envelope.clear();
  }

  /** Return the rows for a window of so many seconds. */
  rows(window_s) {
    const { recent, envelope } = this;
    const reaches = !recent.forgotten || recent.last(0) - recent.value(0, 0) >= window_s;
    return reaches ? recent : envelope.rows;
  }
}

/** Return the first place in an increasing array whose value is at least `value`. */
export function firstAtLeast(sorted, value) {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}
