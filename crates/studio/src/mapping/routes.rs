//! The mapping page's addresses: the page, its socket, and the place where it brings a recording.

use std::time::Duration;

use axum::{
    Router,
    body::Body,
    extract::{
        Query, Request as HttpRequest, State as Shared, WebSocketUpgrade,
        ws::{Message as Frame, WebSocket},
    },
    http::{HeaderMap, StatusCode, header::CONTENT_LENGTH},
    response::{IntoResponse, Response},
    routing::{get, post},
};
use futures_util::{
    FutureExt, SinkExt, StreamExt,
    future::{BoxFuture, OptionFuture},
    stream::SplitSink,
};
use serde::{Deserialize, Serialize};
use tokio::{sync::OwnedSemaphorePermit, time::Instant};

use super::{
    Mapping,
    board::Message,
    protocol::Request,
    source::{self, UPLOAD_BYTES_MAX},
    stage::PageSeen,
};
use crate::door::{self, Allowance};

/// Longest message the page may send, bytes; a request with every parameter is below 20 000.
const REQUEST_BYTES_MAX: usize = 32 * 1024;
/// A recording of which nothing comes for so long is given up.
const PIECE_PATIENCE: Duration = Duration::from_secs(10);
/// Slowest pace of a recording after that, bytes per second: a long line over a slow link is faster.
const PACE_MIN_BPS: f64 = 64.0 * 1024.0;

/// The addresses under which the page talks to us.
pub(crate) fn routes(mapping: Mapping) -> Router {
    Router::new()
        .route("/map/ws", get(socket))
        .route("/map/recording", post(bring))
        .with_state(mapping)
}

/// What is brought: the log, and behind it in the same body its poses and true poses, if they are files of their own.
#[derive(Debug, Deserialize)]
struct Brought {
    name: String,
    #[serde(default)]
    poses_bytes: usize,
    #[serde(default)]
    truth_bytes: usize,
}

async fn bring(
    Shared(mapping): Shared<Mapping>,
    Query(brought): Query<Brought>,
    request: HttpRequest,
) -> Response {
    let name: String = brought.name.chars().filter(|c| !c.is_control()).take(200).collect();
    // What is too long, or comes while another is read, is not even taken.
    if told_length(request.headers()) > UPLOAD_BYTES_MAX {
        return too_long(&name);
    }
    let reading = match mapping.begin_reading() {
        Ok(reading) => reading,
        Err(text) => return (StatusCode::CONFLICT, text).into_response(),
    };
    let body = match take(request.into_body()).await {
        Ok(body) => body,
        Err(NotTaken::TooLong) => return too_long(&name),
        Err(NotTaken::TooSlow) => {
            let text = format!("{name}: it came too slowly and was given up; send it again");
            return (StatusCode::REQUEST_TIMEOUT, text).into_response();
        }
        Err(NotTaken::Broken) => {
            let text = format!("{name}: the connection broke before all of it was there");
            return (StatusCode::BAD_REQUEST, text).into_response();
        }
    };
    let log_bytes = brought
        .poses_bytes
        .checked_add(brought.truth_bytes)
        .and_then(|others| body.len().checked_sub(others));
    let Some(log_bytes) = log_bytes else {
        let text = format!("{name}: the files are shorter than the page said; choose them again");
        return (StatusCode::BAD_REQUEST, text).into_response();
    };
    let read = {
        let name = name.clone();
        move || {
            let (log, others) = body.split_at(log_bytes);
            let (poses, truth) = others.split_at(brought.poses_bytes);
            let file = |bytes| Some(bytes).filter(|bytes: &&[u8]| !bytes.is_empty());
            source::read(&name, log, file(poses), file(truth))
        }
    };
    match mapping.load(reading, name, read).await {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(text) => (StatusCode::UNPROCESSABLE_ENTITY, text).into_response(),
    }
}

fn too_long(name: &str) -> Response {
    let megabytes = UPLOAD_BYTES_MAX / (1024 * 1024);
    let text = format!(
        "{name}: a page may bring at most {megabytes} MB; give a larger log to the program: \
         cairn map FILE --show"
    );
    (StatusCode::PAYLOAD_TOO_LARGE, text).into_response()
}

/// Why a body was not taken.
enum NotTaken {
    TooLong,
    TooSlow,
    Broken,
}

/// Takes a body that comes at a fair pace, and no more of it than is allowed.
async fn take(body: Body) -> Result<Vec<u8>, NotTaken> {
    let mut pieces = body.into_data_stream();
    let mut taken = Vec::new();
    let begun = Instant::now();
    loop {
        let piece = match tokio::time::timeout(PIECE_PATIENCE, pieces.next()).await {
            Ok(Some(Ok(piece))) => piece,
            Ok(Some(Err(_))) => return Err(NotTaken::Broken),
            Ok(None) => return Ok(taken),
            Err(_) => return Err(NotTaken::TooSlow),
        };
        if taken.len() + piece.len() > UPLOAD_BYTES_MAX {
            return Err(NotTaken::TooLong);
        }
        taken.extend_from_slice(&piece);
        let due_bytes = begun.elapsed().saturating_sub(PIECE_PATIENCE).as_secs_f64() * PACE_MIN_BPS;
        if (taken.len() as f64) < due_bytes {
            return Err(NotTaken::TooSlow);
        }
    }
}

/// The length that the body claims, bytes.
fn told_length(headers: &HeaderMap) -> usize {
    let told = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse().ok());
    told.unwrap_or(0)
}

async fn socket(Shared(mapping): Shared<Mapping>, upgrade: WebSocketUpgrade) -> Response {
    match mapping.pages.enter() {
        Ok(place) => door::bounded(upgrade, REQUEST_BYTES_MAX)
            .on_upgrade(move |socket| serve_page(mapping, socket, place)),
        Err(text) => (StatusCode::SERVICE_UNAVAILABLE, text).into_response(),
    }
}

type Outbox = SplitSink<WebSocket, Frame>;
type Asked = OptionFuture<BoxFuture<'static, Result<(), String>>>;

/// Serves one page until it leaves. A slow page misses moments, never memory.
async fn serve_page(mapping: Mapping, socket: WebSocket, place: OwnedSemaphorePermit) {
    let (mut outbox, mut inbox) = socket.split();
    let mut bell = mapping.stage.listen();
    bell.mark_changed();
    let mut seen = PageSeen::default();
    let mut allowance = Allowance::new();
    // One quick request at a time, the next waits in the page's socket; and beside it one sample that is made, which
    // takes seconds in which the page wants to see that it is made.
    let (mut asked, mut made) = (Asked::from(None), Asked::from(None));
    let (mut is_asking, mut is_making) = (false, false);
    loop {
        let sent = tokio::select! {
            biased;
            Some(outcome) = &mut asked, if is_asking => {
                (asked, is_asking) = (None.into(), false);
                refuse(&mut outbox, outcome).await
            }
            Some(outcome) = &mut made, if is_making => {
                (made, is_making) = (None.into(), false);
                refuse(&mut outbox, outcome).await
            }
            request = inbox.next(), if !is_asking => match request {
                Some(Ok(Frame::Text(text))) => {
                    allowance.take().await;
                    match serde_json::from_str::<Request>(&text) {
                        Ok(Request::Sample { .. }) if is_making => {
                            refuse(&mut outbox, Err("a sample is being made already".to_owned())).await
                        }
                        Ok(request @ Request::Sample { .. }) => {
                            (made, is_making) = (Some(mapping.ask(request).boxed()).into(), true);
                            Ok(())
                        }
                        Ok(request) => {
                            (asked, is_asking) = (Some(mapping.ask(request).boxed()).into(), true);
                            Ok(())
                        }
                        Err(error) => {
                            let text = format!("this message was not understood: {error}");
                            refuse(&mut outbox, Err(text)).await
                        }
                    }
                }
                Some(Ok(Frame::Close(_)) | Err(_)) | None => break,
                Some(Ok(_)) => {
                    allowance.take().await;
                    Ok(())
                }
            },
            changed = bell.changed() => {
                if changed.is_err() {
                    break;
                }
                bell.mark_unchanged();
                match catch_up(&mapping, &mut seen, &mut outbox).await {
                    Ok(more) => {
                        if more {
                            bell.mark_changed();
                        }
                        Ok(())
                    }
                    Err(error) => Err(error),
                }
            }
        };
        if sent.is_err() {
            break;
        }
    }
    drop(place);
}

/// Sends some of what the page has not seen; whether there is more. Requests are heard in between.
async fn catch_up(
    mapping: &Mapping,
    seen: &mut PageSeen,
    outbox: &mut Outbox,
) -> Result<bool, axum::Error> {
    let (messages, more) = mapping.stage.news(seen);
    for message in messages {
        send(outbox, message).await?;
    }
    Ok(more)
}

async fn send(outbox: &mut Outbox, message: Message) -> Result<(), axum::Error> {
    let frame = match message {
        Message::Text(text) => Frame::Text(text.into()),
        Message::Binary(bytes) => Frame::Binary(bytes.into()),
    };
    outbox.send(frame).await
}

/// Tells the page why its request could not be carried out, if so.
async fn refuse(outbox: &mut Outbox, outcome: Result<(), String>) -> Result<(), axum::Error> {
    let Err(text) = outcome else { return Ok(()) };
    send(outbox, Message::Text(refusal_text(&text))).await
}

/// The answer to a request that cannot be carried out.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "error")]
struct Refusal<'a> {
    text: &'a str,
}

fn refusal_text(text: &str) -> String {
    serde_json::to_string(&Refusal { text }).unwrap_or_default()
}
