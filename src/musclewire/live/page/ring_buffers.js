/** Rows kept for the plots, never more than a fixed number. Pure: no page, no clock. */

/** The last rows by columns: at least `capacity` of them once so many came, and never twice as many. */
export class LastRows {
  constructor(width, capacity) {
    this.capacity = capacity;
    this.columns = Array.from({ length: width }, () => []);
    this.forgotten = false;
  }

  get length() {
    return this.columns[0].length;
  }

  /** Append a row; when twice the capacity is there, the older half goes, in place. */
  push(row) {
    if (this.length >= 2 * this.capacity) this.dropOlder();
    for (let place = 0; place < this.columns.length; place += 1) this.columns[place].push(row[place]);
  }

  dropOlder() {
    const surplus = this.length - this.capacity;
    for (const column of this.columns) {
      column.copyWithin(0, surplus);
      column.length = this.capacity;
    }
    this.forgotten = true;
  }

  clear() {
    for (const column of this.columns) column.length = 0;
    this.forgotten = false;
  }

  /** Return the value of a column in the newest row, or null. */
  last(place) {
    return this.length ? this.columns[place][this.length - 1] : null;
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

  /** Return the columns for a window of so many seconds. */
  columns(window_s) {
    const { recent, envelope } = this;
    const reaches = !recent.forgotten || recent.last(0) - recent.columns[0][0] >= window_s;
    return reaches ? recent.columns : envelope.rows.columns;
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
