// Audio worklet: resamples the microphone to 16 kHz in pieces of 20 ms, off the main thread. Uses a windowed sinc,
// because linear interpolation would alias sound above 8 kHz into speech.

const RATE = 16000;
const PIECE = 320; // samples: 20 ms
const HALF = 16; // zero crossings of the sinc on either side
const PHASES = 64; // between two input samples

class SincWorklet extends AudioWorkletProcessor {
  #step = sampleRate / RATE; // input samples per output sample
  #reach = Math.ceil(HALF * Math.max(1, sampleRate / RATE)); // input samples on either side
  #table = filters(Math.min(1, RATE / sampleRate), Math.ceil(HALF * Math.max(1, sampleRate / RATE)));
  #past = new Float32Array(0);
  #at = 0; // of the next output sample, in samples of #past
  #piece = new Int16Array(PIECE);
  #filled = 0;
  #count = 0; // of the pieces so far: their clock
  #power = 0;
  #peak = 0;

  /** @param {Float32Array[][]} inputs @returns {boolean} */
  process(inputs) {
    const channels = inputs[0] ?? [];
    const [first] = channels;
    if (!first) return true;
    const joined = new Float32Array(this.#past.length + first.length);
    joined.set(this.#past);
    for (const channel of channels)
      for (let n = 0; n < channel.length; n += 1)
        joined[this.#past.length + n] = (joined[this.#past.length + n] ?? 0) + (channel[n] ?? 0) / channels.length;
    while (this.#at + this.#reach < joined.length) {
      if (this.#at >= this.#reach) this.#put(this.#value(joined));
      this.#at += this.#step;
    }
    const keep = Math.max(0, Math.floor(this.#at) - this.#reach - 1);
    this.#past = joined.slice(keep);
    this.#at -= keep;
    return true;
  }

  /** @param {Float32Array} sound */
  #value(sound) {
    const whole = Math.floor(this.#at);
    const phase = Math.round((this.#at - whole) * PHASES);
    const weights = this.#table[phase] ?? new Float32Array(0);
    const from = whole - this.#reach + 1;
    let sum = 0;
    for (let n = 0; n < weights.length; n += 1) sum += (weights[n] ?? 0) * (sound[from + n] ?? 0);
    return sum;
  }

  /** @param {number} value */
  #put(value) {
    this.#power += value * value;
    this.#peak = Math.max(this.#peak, Math.abs(value));
    this.#piece[this.#filled] = Math.max(-32768, Math.min(32767, Math.round(value * 32767)));
    this.#filled += 1;
    if (this.#filled < PIECE) return;
    const { buffer } = this.#piece;
    const at = (1000 * this.#count * PIECE) / RATE;
    this.port.postMessage({ pcm: buffer, at, rms: Math.sqrt(this.#power / PIECE), peak: this.#peak }, [buffer]);
    this.#piece = new Int16Array(PIECE);
    this.#count += 1;
    this.#filled = this.#power = this.#peak = 0;
  }
}

/**
 * A windowed sinc for every phase between two input samples.
 * @param {number} cut of the input's Nyquist frequency that passes
 * @param {number} reach input samples on either side
 */
function filters(cut, reach) {
  return Array.from({ length: PHASES + 1 }, (_, phase) => {
    const weights = new Float32Array(2 * reach);
    let sum = 0;
    for (let n = 0; n < weights.length; n += 1) {
      const x = n - reach + 1 - phase / PHASES;
      const window = Math.abs(x) < reach ? 0.5 + 0.5 * Math.cos((Math.PI * x) / reach) : 0;
      const sinc = Math.abs(x) < 1e-9 ? 1 : Math.sin(Math.PI * cut * x) / (Math.PI * cut * x);
      weights[n] = window * sinc;
      sum += weights[n] ?? 0;
    }
    return weights.map((weight) => weight / sum);
  });
}

registerProcessor("sinc-worklet", SincWorklet);
