//! The web server: the pages, their assets, and the WebSocket that carries the run.
//!
//! It answers this computer only. The socket is refused to pages of other origins, so that no web
//! site that happens to be open in the same browser can steer a robot.

use std::net::SocketAddr;

use axum::{
    Json, Router,
    extract::{
        Path, Request as HttpRequest, State as Shared, WebSocketUpgrade,
        ws::{Message, WebSocket},
    },
    http::{HeaderMap, HeaderValue, StatusCode, header},
    middleware::{self, Next},
    response::{Html, IntoResponse, Redirect, Response},
    routing::get,
};
use futures_util::{SinkExt, StreamExt, stream::SplitSink};
use rust_embed::RustEmbed;
use tokio::sync::broadcast::error::RecvError;

use crate::{
    mapping::{self, Mapping},
    protocol::{MissionName, Refusal, Request},
    runner::Remote,
};

#[derive(RustEmbed)]
#[folder = "web/dist"]
struct Assets;

/// Longest message the page may send, bytes; its requests are below 200.
const REQUEST_BYTES_MAX: usize = 64 * 1024;

/// The mission page: the run that it shows, and the missions that it offers.
#[derive(Clone)]
pub(crate) struct MissionPage {
    pub remote: Remote,
    pub missions: std::sync::Arc<Vec<MissionName>>,
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
            .route("/ws", get(socket))
            .with_state(mission),
        None => Router::new().route("/", get(|| async { Redirect::temporary("/map") })),
    };
    pages
        .route("/map", get(|| async { page("map.html") }))
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
        Some(file) => Html(file.data.into_owned()).into_response(),
        None => (StatusCode::NOT_FOUND, "the page is not part of this build").into_response(),
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
    ([(header::CONTENT_TYPE, kind)], file.data.into_owned()).into_response()
}

async fn missions(Shared(app): Shared<MissionPage>) -> Json<Vec<MissionName>> {
    Json(app.missions.to_vec())
}

async fn socket(Shared(app): Shared<MissionPage>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(REQUEST_BYTES_MAX)
        .on_upgrade(move |socket| serve_page(app.remote, socket))
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

type Outbox = SplitSink<WebSocket, Message>;

/// Serves one page until it leaves. A slow page misses states, never memory.
async fn serve_page(remote: Remote, socket: WebSocket) {
    let (mut outbox, mut inbox) = socket.split();
    let mut hello = remote.hello.clone();
    let mut state = remote.state.clone();
    let mut news = remote.news.subscribe();
    hello.mark_changed();
    // The run that this page has been greeted with; it hears of no other.
    let mut run = None;
    loop {
        let sent = tokio::select! {
            biased;
            request = inbox.next() => match request {
                Some(Ok(Message::Text(text))) => answer(&remote, &mut outbox, &text).await,
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => Ok(()),
            },
            changed = hello.changed() => {
                if changed.is_err() {
                    return;
                }
                let greeting = hello.borrow_and_update().clone();
                run = Some(greeting.run);
                state.mark_changed();
                let log = remote.log.borrow().clone();
                match send(&mut outbox, &greeting.text).await {
                    Ok(()) if log.run == greeting.run => send(&mut outbox, &log.text).await,
                    sent => sent,
                }
            }
            item = news.recv() => match item {
                Ok(item) if run == Some(item.run) => send(&mut outbox, &item.text).await,
                Ok(_) | Err(RecvError::Lagged(_)) => Ok(()),
                Err(RecvError::Closed) => return,
            },
            changed = state.changed() => {
                if changed.is_err() {
                    return;
                }
                let newest = state.borrow_and_update().clone();
                if run == Some(newest.run) { send(&mut outbox, &newest.text).await } else { Ok(()) }
            }
        };
        if sent.is_err() {
            return;
        }
    }
}

async fn send(outbox: &mut Outbox, text: &str) -> Result<(), axum::Error> {
    if text.is_empty() {
        return Ok(());
    }
    outbox.send(Message::Text(text.into())).await
}

/// Hands a request on, and tells the page when that cannot be done.
async fn answer(remote: &Remote, outbox: &mut Outbox, text: &str) -> Result<(), axum::Error> {
    let outcome = match serde_json::from_str::<Request>(text) {
        Ok(request) => remote.ask(request).await,
        Err(error) => Err(format!("this message was not understood: {error}")),
    };
    match outcome {
        Ok(()) => Ok(()),
        Err(text) => {
            let refusal = serde_json::to_string(&Refusal { text }).unwrap_or_default();
            send(outbox, &refusal).await
        }
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
        for name in ["index.html", "map.html"] {
            let page = Assets::get(name).unwrap();
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
