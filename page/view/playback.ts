// Frames of a motion, played at their own times: a button, a slider and the time.
export interface Motion {
  /** When each frame was, in s, ascending. */
  times_s: number[];
}

/** A bar below a view. `show` is called with the place of the frame that is to be seen. */
export class Playback {
  readonly element: HTMLElement;
  private readonly button: HTMLButtonElement;
  private readonly slider: HTMLInputElement;
  private readonly output: HTMLOutputElement;
  private running = 0;
  private startedAt = 0;
  private startedFrom = 0;

  /** `slowness`: seconds of the clock for a second of the motion. */
  constructor(private readonly motion: Motion, private readonly show: (frame: number) => void, private readonly slowness = 1) {
    this.button = Object.assign(document.createElement("button"), { type: "button" });
    this.slider = Object.assign(document.createElement("input"), { type: "range", min: "0", max: String(motion.times_s.length - 1), step: "1", value: "0" });
    this.slider.setAttribute("aria-label", "Time of the motion");
    this.output = document.createElement("output");
    this.element = Object.assign(document.createElement("div"), { className: "playback" });
    this.element.append(this.button, this.slider, this.output);
    this.button.addEventListener("click", () => (this.running ? this.pause() : this.play()));
    this.slider.addEventListener("input", () => {
      this.pause();
      this.goTo(Number(this.slider.value));
    });
    this.pause();
    this.goTo(0);
  }

  get frame(): number {
    return Number(this.slider.value);
  }

  goTo(frame: number): void {
    this.slider.value = String(frame);
    const text = `${this.motion.times_s[frame]!.toFixed(3)} s`;
    this.output.value = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.show(frame);
  }

  play(): void {
    const { times_s } = this.motion;
    if (this.frame >= times_s.length - 1) this.goTo(0);
    this.startedAt = performance.now();
    this.startedFrom = times_s[this.frame]!;
    this.button.textContent = "Pause";
    this.running = requestAnimationFrame((now) => this.advance(now));
  }

  pause(): void {
    cancelAnimationFrame(this.running);
    this.running = 0;
    this.button.textContent = "Play";
  }

  private advance(now: number): void {
    const { times_s } = this.motion;
    const time = this.startedFrom + (now - this.startedAt) / 1000 / this.slowness;
    let frame = this.frame;
    while (frame + 1 < times_s.length && times_s[frame + 1]! <= time) frame++;
    if (frame !== this.frame) this.goTo(frame);
    if (frame >= times_s.length - 1) this.pause();
    else this.running = requestAnimationFrame((next) => this.advance(next));
  }
}
