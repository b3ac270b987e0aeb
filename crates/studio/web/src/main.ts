// The studio's page: a frame around what the session has. At /map that is a survey, else a run.

import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/layout.css";
import "./styles/map.css";
import "./styles/panels.css";
import "./styles/editor.css";
import "./styles/mapping.css";
import { openSurvey } from "./mapping/survey";
import { openRun } from "./run";

if (location.pathname.replace(/\/$/, "") === "/map") openSurvey();
else openRun();
