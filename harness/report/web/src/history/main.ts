import { h } from "../dom";
import { readHistory } from "./data";

const history = readHistory();
document.getElementById("page")!.append(h("h1", {}, history.project));
