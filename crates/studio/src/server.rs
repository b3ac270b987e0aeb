//! The web server: the pages, their assets, and the WebSocket that carries the run.
//!
//! It answers this computer only. The socket is refused to pages of other origins, so that no web
//! site that happens to be open in the same browser can steer a robot.

use std::{
    borrow::Cow,
    net::SocketAddr,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use axum::{
    Json, Router,
    body::{Body, to_bytes},
    extract::{
        Path, Query, Request as HttpRequest, State as Shared, WebSocketUpgrade,
        ws::{Message, Utf8Bytes, WebSocket},
    },
    http::{HeaderMap, HeaderValue, StatusCode, header},
    middleware::{self, Next},
    response::{IntoResponse, Redirect, Response},
    routing::{get, post},
};
use futures_util::{
    FutureExt, SinkExt, StreamExt,
    future::{BoxFuture, OptionFuture},
    stream::{SplitSink, SplitStream},
};
use rust_embed::RustEmbed;
use serde::Deserialize;
use tokio::sync::{
    OwnedSemaphorePermit,
    broadcast::{self, error::RecvError},
    watch,
};

use crate::{
    door::{self, Allowance, Pages},
    library::{self, Library},
    mapping::{self, Mapping},
    protocol::{MissionName, Refusal, Request},
    runner::{Remote, Told},
};

#[derive(RustEmbed)]
#[folder = "web/dist"]
struct Assets;

/// Longest message the page may send, bytes; its requests are below 200. A page that sends more is shown out.
const REQUEST_BYTES_MAX: usize = 4 * 1024;
/// Longest mission that a page may bring, bytes: ten times the longest that is shipped.
const MISSION_BYTES_MAX: usize = 256 * 1024;
/// Time in which it must be there.
const MISSION_PATIENCE: Duration = Duration::from_secs(10);

/// The mission page: the run that it shows, and the missions that it offers.
#[derive(Clone)]
pub(crate) struct MissionPage {
    pub remote: Remote,
    pub library: Arc<Mutex<Library>>,
    pub pages: Pages,
}

/// All routes of the studio. Without a mission the mapping page stands in its place.
pub(crate) fn router(
    mission: Option<MissionPage>,
    mapping: Mapping,
    address: SocketAddr,
) -> Router {
    let pages = match mission {
        Some(mission) => Router::new()
            .route("/", get(|| async { page("index.html") }))
            .route("/api/missions", get(missions))
            .route("/api/mission", post(bring_mission))
            .route("/ws", get(socket))
            .with_state(mission),
        None => Router::new().route("/", get(|| async { Redirect::temporary("/map") })),
    };
    pages
        .route("/map", get(|| async { page("index.html") }))
        .route("/assets/{*name}", get(asset))
        .route("/healthz", get(|| async { "ok" }))
        .merge(mapping::routes(mapping))
        .layer(middleware::from_fn_with_state(address.port(), guard))
}

/// Turns foreign pages and names away, and tells the browser what our page may do.
async fn guard(Shared(port): Shared<u16>, request: HttpRequest, next: Next) -> Response {
    let mut response = if is_own_page(request.headers(), port) {
        next.run(request).await
    } else {
        let text = "only the studio's own page may connect; open the address that cairn printed";
        (StatusCode::FORBIDDEN, text).into_response()
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CACHE_CONTROL, "no-cache"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if let Ok(policy) = HeaderValue::from_str(&content_policy(port)) {
        headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    response
}

/// The policy in the page's head, with the socket's address spelled out and no frames around it.
fn content_policy(port: u16) -> String {
    format!(
        "default-src 'self'; connect-src 'self' ws://127.0.0.1:{port} ws://localhost:{port}; \
         img-src 'self' data:; style-src 'self' 'unsafe-inline'; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'"
    )
}

fn page(name: &str) -> Response {
    match Assets::get(name) {
        Some(file) => {
            let kind = (header::CONTENT_TYPE, "text/html; charset=utf-8");
            ([kind], content(file.data)).into_response()
        }
        None => (StatusCode::NOT_FOUND, "the page is not part of this build").into_response(),
    }
}

/// What is embedded is sent from where it is: a client that does not take it costs nothing.
fn content(data: Cow<'static, [u8]>) -> Body {
    match data {
        Cow::Borrowed(bytes) => Body::from(bytes),
        Cow::Owned(bytes) => Body::from(bytes),
    }
}

async fn asset(Path(name): Path<String>) -> Response {
    let Some(file) = Assets::get(&format!("assets/{name}")) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let kind = match name.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("txt") => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    };
    ([(header::CONTENT_TYPE, kind)], content(file.data)).into_response()
}

async fn missions(Shared(app): Shared<MissionPage>) -> Json<Vec<MissionName>> {
    Json(app.library.lock().unwrap_or_else(PoisonError::into_inner).names())
}

/// The file's name of a mission that a page brings.
#[derive(Deserialize)]
struct Brought {
    name: String,
    /// Bytes of a file that is too large; then only its beginning is sent, to be told what it is.
    bytes: Option<u64>,
}

/// Reads a mission that a page brings, puts it into the list and begins it.
async fn bring_mission(
    Shared(app): Shared<MissionPage>,
    Query(brought): Query<Brought>,
    request: HttpRequest,
) -> Response {
    let file: String = brought.name.chars().filter(|c| !c.is_control()).take(200).collect();
    let body =
        tokio::time::timeout(MISSION_PATIENCE, to_bytes(request.into_body(), MISSION_BYTES_MAX));
    let Ok(Ok(body)) = body.await else {
        let text = format!(
            "{file}: a mission that a page brings has at most {} kB and comes within ten seconds",
            MISSION_BYTES_MAX / 1024
        );
        return (StatusCode::PAYLOAD_TOO_LARGE, text).into_response();
    };
    let library = app.library.clone();
    let read = tokio::task::spawn_blocking(move || {
        if let Some(bytes) = brought.bytes {
            return Err(library::too_large(&file, &body, bytes, MISSION_BYTES_MAX));
        }
        let text = files::text_of(file.as_ref(), "the mission", body.into())
            .map_err(|error| error.to_string())?;
        let mission = library::read(&file, text.strip_prefix('\u{feff}').unwrap_or(&text))?;
        Ok::<_, String>(library.lock().unwrap_or_else(PoisonError::into_inner).keep(&mission))
    });
    let begun = match read.await {
        Ok(Ok(name)) => app.remote.ask(Request::Restart { seed: None, mission: Some(name) }).await,
        Ok(Err(text)) => Err(text),
        Err(_) => Err("reading it failed by a fault of ours".to_owned()),
    };
    match begun {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(text) => (StatusCode::UNPROCESSABLE_ENTITY, text).into_response(),
    }
}

async fn socket(Shared(app): Shared<MissionPage>, upgrade: WebSocketUpgrade) -> Response {
    match app.pages.enter() {
        Ok(place) => door::bounded(upgrade, REQUEST_BYTES_MAX)
            .on_upgrade(move |socket| Guest::new(app.remote, socket, place).serve()),
        Err(text) => (StatusCode::SERVICE_UNAVAILABLE, text).into_response(),
    }
}

/// Whether the request comes from a page that this server served.
///
/// A browser always names the origin of the page that opens a socket; a program that names none is
/// not a browser and has no other pages' cookies or users to abuse. The host is checked as well, so
/// that a foreign name which resolves to this computer does not pass.
fn is_own_page(headers: &HeaderMap, port: u16) -> bool {
    let ours = |authority: &str| {
        let hosts = ["127.0.0.1", "localhost", "[::1]"];
        // Browsers leave the default port out.
        let is =
            |host: &str| authority == format!("{host}:{port}") || (port == 80 && authority == host);
        hosts.into_iter().any(is)
    };
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let host_is_ours = text(header::HOST).is_some_and(ours);
    let origin_is_ours = match text(header::ORIGIN) {
        Some(origin) => origin.strip_prefix("http://").is_some_and(ours),
        None => true,
    };
    host_is_ours && origin_is_ours
}

/// One page with what it has been sent.
struct Guest {
    remote: Remote,
    outbox: SplitSink<WebSocket, Message>,
    inbox: SplitStream<WebSocket>,
    hello: watch::Receiver<Told>,
    state: watch::Receiver<Told>,
    news: broadcast::Receiver<Told>,
    /// The run that this page has been greeted with; it hears of no other.
    run: Option<u64>,
    allowance: Allowance,
    /// What it has asked for and was not answered yet: one thing at a time, the next waits in its socket.
    asked: OptionFuture<BoxFuture<'static, Result<Utf8Bytes, String>>>,
    /// The robot that it drives by hand.
    drives: Option<usize>,
    _place: OwnedSemaphorePermit,
}

impl Guest {
    fn new(remote: Remote, socket: WebSocket, place: OwnedSemaphorePermit) -> Self {
        let (outbox, inbox) = socket.split();
        let (hello, state, news) =
            (remote.hello.clone(), remote.state.clone(), remote.news.subscribe());
        Self {
            remote,
            outbox,
            inbox,
            hello,
            state,
            news,
            run: None,
            allowance: Allowance::new(),
            asked: None.into(),
            drives: None,
            _place: place,
        }
    }

    /// Serves the page until it leaves, and takes its hand off the robot then.
    async fn serve(mut self) {
        self.talk().await;
        if let Some(robot) = self.drives {
            let stand = Request::Drive { robot, speed_mps: 0.0, turn_rate_radps: 0.0 };
            // A run that is over or stands still moves nobody.
            drop(self.remote.ask(stand).await);
        }
    }

    /// A slow page misses states, never memory.
    async fn talk(&mut self) {
        self.hello.mark_changed();
        let mut is_busy = false;
        loop {
            let sent = tokio::select! {
                biased;
                Some(outcome) = &mut self.asked, if is_busy => {
                    is_busy = false;
                    self.asked = None.into();
                    self.answer(outcome).await
                }
                request = self.inbox.next(), if !is_busy => match request {
                    Some(Ok(Message::Text(text))) => {
                        self.allowance.take().await;
                        is_busy = true;
                        self.ask(&text);
                        Ok(())
                    }
                    Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                    Some(Ok(_)) => {
                        self.allowance.take().await;
                        Ok(())
                    }
                },
                changed = self.hello.changed() => match changed {
                    Ok(()) => self.greet().await,
                    Err(_) => return,
                },
                item = self.news.recv() => match item {
                    Ok(item) if self.run == Some(item.run) => self.send(item.text).await,
                    Ok(_) | Err(RecvError::Lagged(_)) => Ok(()),
                    Err(RecvError::Closed) => return,
                },
                changed = self.state.changed() => {
                    if changed.is_err() {
                        return;
                    }
                    let newest = self.state.borrow_and_update().clone();
                    if self.run == Some(newest.run) { self.send(newest.text).await } else { Ok(()) }
                }
            };
            if sent.is_err() {
                return;
            }
        }
    }

    /// Tells of a run that the page does not know yet.
    async fn greet(&mut self) -> Result<(), axum::Error> {
        let greeting = self.hello.borrow_and_update().clone();
        self.run = Some(greeting.run);
        self.state.mark_changed();
        let log = self.remote.log.borrow().clone();
        self.send(greeting.text).await?;
        if log.run == greeting.run {
            self.send(log.text).await?;
        }
        self.send(self.remote.past_of(greeting.run)).await
    }

    async fn send(&mut self, text: Utf8Bytes) -> Result<(), axum::Error> {
        if text.is_empty() {
            return Ok(());
        }
        self.outbox.send(Message::Text(text)).await
    }

    /// Begins to hand a request on.
    fn ask(&mut self, text: &str) {
        let outcome = match serde_json::from_str::<Request>(text) {
            Ok(request) => {
                if let Request::Drive { robot, speed_mps, turn_rate_radps } = request {
                    let moves = speed_mps != 0.0 || turn_rate_radps != 0.0;
                    self.drives = moves.then_some(robot);
                }
                let remote = self.remote.clone();
                let run = self.run.unwrap_or_default();
                async move {
                    match request {
                        Request::Past { t_s } => remote.look_back(run, t_s),
                        request => remote.ask(request).await.map(|()| Utf8Bytes::default()),
                    }
                }
                .boxed()
            }
            Err(error) => {
                let text = format!("this message was not understood: {error}");
                std::future::ready(Err(text)).boxed()
            }
        };
        self.asked = Some(outcome).into();
    }

    /// Tells the page what it asked for, or why its request could not be carried out.
    async fn answer(&mut self, outcome: Result<Utf8Bytes, String>) -> Result<(), axum::Error> {
        let text = outcome.unwrap_or_else(|text| {
            serde_json::to_string(&Refusal { text }).unwrap_or_default().into()
        });
        self.send(text).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(host: &str, origin: Option<&str>) -> bool {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        is_own_page(&headers, 7878)
    }

    #[test]
    fn its_own_page_may_connect_under_each_name_of_this_computer() {
        for host in ["127.0.0.1:7878", "localhost:7878", "[::1]:7878"] {
            assert!(check(host, Some(&format!("http://{host}"))), "{host}");
        }
        assert!(check("127.0.0.1:7878", None), "a program that is no browser names no origin");
    }

    /// What the page's own head allows, the header must not forbid, but for the socket's exact address.
    #[test]
    fn the_header_allows_what_the_page_says_it_needs() {
        let page = Assets::get("index.html").unwrap();
        let page = String::from_utf8(page.data.into_owned()).unwrap();
        let header = content_policy(7878);
        let start = page.find("default-src").unwrap();
        let meta = &page[start..start + page[start..].find('"').unwrap()];
        for directive in meta.split("; ").filter(|d| !d.starts_with("connect-src")) {
            assert!(header.contains(directive), "{directive}");
        }
        assert!(meta.contains("connect-src 'self' ws:"));
        assert!(header.contains("ws://localhost:7878"));
    }

    #[test]
    fn foreign_pages_and_foreign_names_may_not() {
        assert!(!check("127.0.0.1:7878", Some("http://example.org")));
        assert!(!check("127.0.0.1:7878", Some("https://127.0.0.1:7878")));
        assert!(!check("127.0.0.1:7878", Some("http://127.0.0.1:7879")));
        assert!(!check("127.0.0.1:7878", Some("null")));
        assert!(!check("rebound.example.org:7878", None));
        assert!(!check("rebound.example.org:7878", Some("http://rebound.example.org:7878")));
    }
}
