//! The mapping page's addresses: the page, its socket, and the place where it brings a recording.

use axum::{
    Router,
    body::to_bytes,
    extract::{
        Query, Request as HttpRequest, State as Shared, WebSocketUpgrade,
        ws::{Message as Frame, WebSocket},
    },
    http::{HeaderMap, StatusCode, header::CONTENT_LENGTH},
    response::{IntoResponse, Response},
    routing::{get, post},
};
use futures_util::{SinkExt, StreamExt, stream::SplitSink};
use serde::{Deserialize, Serialize};
use tokio::sync::mpsc;

use super::{
    Mapping, UPLOAD_BYTES_MAX, board::Message, protocol::Request, source, stage::PageSeen,
};

/// Longest message the page may send, bytes; a request with every parameter is below 20 000.
const REQUEST_BYTES_MAX: usize = 128 * 1024;

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
    let body = if told_length(request.headers()) > UPLOAD_BYTES_MAX {
        // What is too long is not even taken.
        None
    } else {
        to_bytes(request.into_body(), UPLOAD_BYTES_MAX).await.ok()
    };
    let Some(body) = body else {
        let megabytes = UPLOAD_BYTES_MAX / (1024 * 1024);
        let text = format!(
            "{name}: a page may bring at most {megabytes} MB; give a larger log to the program: \
             cairn map FILE --show"
        );
        return (StatusCode::PAYLOAD_TOO_LARGE, text).into_response();
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
    match mapping.load(name, read).await {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(text) => (StatusCode::UNPROCESSABLE_ENTITY, text).into_response(),
    }
}

/// The length that the body claims, bytes.
fn told_length(headers: &HeaderMap) -> usize {
    let told = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse().ok());
    told.unwrap_or(0)
}

async fn socket(Shared(mapping): Shared<Mapping>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(REQUEST_BYTES_MAX)
        .on_upgrade(move |socket| serve_page(mapping, socket))
}

type Outbox = SplitSink<WebSocket, Frame>;

/// Serves one page until it leaves. A slow page misses moments, never memory.
async fn serve_page(mapping: Mapping, socket: WebSocket) {
    let (mut outbox, mut inbox) = socket.split();
    let mut bell = mapping.stage.listen();
    bell.mark_changed();
    let mut seen = PageSeen::default();
    let (answers, mut answered) = mpsc::channel::<String>(8);
    loop {
        let sent = tokio::select! {
            biased;
            request = inbox.next() => match request {
                Some(Ok(Frame::Text(text))) => {
                    answer(&mapping, &text, answers.clone());
                    Ok(())
                }
                Some(Ok(Frame::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => Ok(()),
            },
            refusal = answered.recv() => match refusal {
                Some(text) => send(&mut outbox, Message::Text(refusal_text(&text))).await,
                None => return,
            },
            changed = bell.changed() => {
                if changed.is_err() {
                    return;
                }
                bell.mark_unchanged();
                catch_up(&mapping, &mut seen, &mut outbox).await
            }
        };
        if sent.is_err() {
            return;
        }
    }
}

async fn catch_up(
    mapping: &Mapping,
    seen: &mut PageSeen,
    outbox: &mut Outbox,
) -> Result<(), axum::Error> {
    loop {
        let (messages, more) = mapping.stage.news(seen);
        for message in messages {
            send(outbox, message).await?;
        }
        if !more {
            return Ok(());
        }
    }
}

async fn send(outbox: &mut Outbox, message: Message) -> Result<(), axum::Error> {
    let frame = match message {
        Message::Text(text) => Frame::Text(text.into()),
        Message::Binary(bytes) => Frame::Binary(bytes.into()),
    };
    outbox.send(frame).await
}

/// Hands a request on, and tells the page when that cannot be done. The page need not wait for it: making a
/// recording takes seconds in which it wants to see that it is made.
fn answer(mapping: &Mapping, text: &str, answers: mpsc::Sender<String>) {
    let carried_out = match serde_json::from_str::<Request>(text) {
        Ok(request) => Ok(mapping.ask(request)),
        Err(error) => Err(format!("this message was not understood: {error}")),
    };
    tokio::spawn(async move {
        let outcome = match carried_out {
            Ok(carried_out) => carried_out.await,
            Err(text) => Err(text),
        };
        if let Err(text) = outcome {
            // A page that left hears no answer.
            drop(answers.send(text).await);
        }
    });
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
