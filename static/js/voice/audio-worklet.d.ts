// What an AudioWorklet finds around itself; TypeScript's library of the page does not have it.

declare const sampleRate: number;

declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}

declare function registerProcessor(name: string, kind: new () => AudioWorkletProcessor): void;
