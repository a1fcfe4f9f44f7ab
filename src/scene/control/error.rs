//! Reasons why signals, a controller or a saved state end a run; the rows recorded so far are kept.

/// A signal or a controller that cannot be used any more, or a saved state that cannot be used at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControlError {
    #[error(
        "the signal {signal} is {value} at t = {t:.6} s; keep its formula defined there, for example by sqrt(max(x, 0)) in place of sqrt(x)"
    )]
    NotFinite { signal: String, value: f64, t: f64 },
    #[error(
        "the controller sets {signal} to {value} at t = {t:.6} s, and its `range` is from {low} to {high} (SI units); keep it within the range, or \
         change the key in the scene"
    )]
    OutOfRange { signal: String, value: f64, t: f64, low: f64, high: f64 },
    #[error("{file}: cannot be written: {reason}; make room, or choose another folder with --out")]
    Record { file: String, reason: String },
    #[error("the state to go on from was saved from another {what}; restart it with the one it belongs to{hint}")]
    Elsewhere { what: &'static str, hint: &'static str },
    #[error(
        "another controller has set the signals up to the saved state at t = {t:.6} s: another program, recording or page, or a file that the command \
         names has changed; go on with the one of that run, or pass --other-controller: the record notes the change"
    )]
    OtherController { t: f64 },
    #[error("the command \"{command}\" is not one: its quotes do not close; write --controller \"python3 ctrl.py\"")]
    Command { command: String },
    #[error("the controller \"{command}\" cannot be started: {reason}; give a program that this shell finds")]
    Start { command: String, reason: String },
    #[error(
        "the controller gave no answer within {seconds} s at t = {t:.6} s; answer every line with one line and flush it, or \
         allow more with --controller-timeout"
    )]
    Late { seconds: f64, t: f64 },
    #[error("stopped while the controller was to answer at t = {t:.6} s")]
    Stopped { t: f64 },
    #[error("the controller ended ({how}) before it answered at t = {t:.6} s; what it said is above")]
    Dead { how: String, t: f64 },
    #[error("the controller wrote at t = {t:.6} s: {line}\n  {fact}; {remedy}")]
    Answer { line: String, t: f64, fact: String, remedy: String },
}
