// All panels of the viewer in one WebGL 2 canvas.
import { Pixels } from "./planes";
import { Display, curves, displays, fragmentShader, vertexShader } from "./shader";

export interface PanelDrawing {
  x: number; y: number; width: number; height: number; // CSS pixels from the canvas's top left
  clip: [number, number]; // shares of the width that are drawn
  pixels: Pixels;
  reference: Pixels | null;
  display: Display;
  unit: number; // what differences are divided by
  scale: number; // end of the colour scale
}

export interface Shared {
  exposure: number;
  curve: string;
  center: [number, number]; // the frame's pixels
  scaleCss: number; // CSS pixels of a pixel of the frame
  frame: [number, number];
  mask: Pixels | null;
}

const uniformNames = ["image", "reference", "mask", "maps", "display", "curve", "step_image", "step_reference",
  "channels", "taps", "has_mask", "panel_origin", "panel_size", "center", "frame", "pixels_per_device",
  "exposure", "mean_luminance", "scale"] as const;

const scratchUnit = 4;

function compile(gl: WebGL2RenderingContext): WebGLProgram {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]] as const) {
    const shader = gl.createShader(type)!;
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "shader");
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "program");
  return program;
}

function mapTexels(colours: string[]): number[] {
  return colours.flatMap((colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)).concat(255));
}

export class Renderer {
  private readonly gl: WebGL2RenderingContext;
  private readonly uniforms = new Map<string, WebGLUniformLocation | null>();
  private textures = new Map<Pixels, WebGLTexture>();

  /** Throws where WebGL 2 is not to be had. */
  constructor(readonly canvas: HTMLCanvasElement, maps: { signed: string[]; positive: string[] }) {
    // The last picture stays for printing and for reading it back.
    const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true, premultipliedAlpha: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    const program = compile(gl);
    gl.useProgram(program);
    for (const name of uniformNames) this.uniforms.set(name, gl.getUniformLocation(program, name));
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const texels = new Uint8Array([...mapTexels(maps.signed), ...mapTexels(maps.positive)]);
    this.bind(3, this.texture(() =>
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, maps.signed.length, 2, 0, gl.RGBA, gl.UNSIGNED_BYTE, texels)));
    ["image", "reference", "mask", "maps"].forEach((name, unit) => gl.uniform1i(this.at(name), unit));
  }

  private at(name: string): WebGLUniformLocation | null { return this.uniforms.get(name) ?? null; }

  private texture(fill: () => void): WebGLTexture {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + scratchUnit); // what is bound for drawing stays bound
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    fill();
    return texture;
  }

  private bind(unit: number, texture: WebGLTexture | null): void {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, texture);
  }

  private textureOf(pixels: Pixels): WebGLTexture {
    let texture = this.textures.get(pixels);
    if (!texture) {
      const gl = this.gl;
      const [internal, format] = pixels.channels === 1 ? [gl.R16F, gl.RED] : [gl.RGB16F, gl.RGB];
      texture = this.texture(() => gl.texImage2D(gl.TEXTURE_2D, 0, internal, pixels.width, pixels.height, 0, format,
        gl.HALF_FLOAT, pixels.halves));
      this.textures.set(pixels, texture);
    }
    return texture;
  }

  draw(width: number, height: number, panels: PanelDrawing[], shared: Shared): void {
    const gl = this.gl, ratio = window.devicePixelRatio || 1;
    const deviceWidth = Math.round(width * ratio), deviceHeight = Math.round(height * ratio);
    if (this.canvas.width !== deviceWidth) this.canvas.width = deviceWidth;
    if (this.canvas.height !== deviceHeight) this.canvas.height = deviceHeight;
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, deviceWidth, deviceHeight);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.SCISSOR_TEST);
    for (const panel of panels) this.drawPanel(panel, shared, ratio, deviceHeight);
  }

  private drawPanel(panel: PanelDrawing, shared: Shared, ratio: number, deviceHeight: number): void {
    const gl = this.gl;
    const left = Math.round(panel.x * ratio), top = Math.round(panel.y * ratio);
    const width = Math.round(panel.width * ratio), height = Math.round(panel.height * ratio);
    const bottom = deviceHeight - top - height;
    const from = left + Math.round(panel.clip[0] * width), to = left + Math.round(panel.clip[1] * width);
    gl.scissor(from, bottom, Math.max(0, to - from), height);
    this.bind(0, this.textureOf(panel.pixels));
    this.bind(1, this.textureOf(panel.reference ?? panel.pixels));
    this.bind(2, this.textureOf(shared.mask ?? panel.pixels));
    const perDevice = 1 / (shared.scaleCss * ratio);
    gl.uniform1i(this.at("display"), displays.indexOf(panel.display));
    gl.uniform1i(this.at("curve"), curves.indexOf(shared.curve as (typeof curves)[number]));
    gl.uniform1i(this.at("step_image"), panel.pixels.step);
    gl.uniform1i(this.at("step_reference"), panel.reference?.step ?? 1);
    gl.uniform1i(this.at("channels"), panel.pixels.channels);
    gl.uniform1i(this.at("taps"), Math.min(Math.max(Math.ceil(perDevice), 1), 6));
    gl.uniform1i(this.at("has_mask"), shared.mask ? 1 : 0);
    gl.uniform2f(this.at("panel_origin"), left, bottom);
    gl.uniform2f(this.at("panel_size"), width, height);
    gl.uniform2f(this.at("center"), ...shared.center);
    gl.uniform2f(this.at("frame"), ...shared.frame);
    gl.uniform1f(this.at("pixels_per_device"), perDevice);
    gl.uniform1f(this.at("exposure"), shared.exposure);
    gl.uniform1f(this.at("mean_luminance"), panel.unit);
    gl.uniform1f(this.at("scale"), panel.scale);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
