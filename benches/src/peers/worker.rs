//! A script of `benches/peers` that stays and is asked line by line, in JSON.

use crate::Failure;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A running script; it goes with the value.
pub(crate) struct Worker {
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// What it said when it was ready.
    pub(crate) greeting: Value,
}

impl Worker {
    /// Starts `script` with `arguments` and waits until it is ready.
    ///
    /// # Errors
    /// If it cannot be started or ends before that; what it said of that is on standard error.
    pub(crate) fn start(
        python: &Path,
        script: &str,
        arguments: impl IntoIterator<Item = String>,
    ) -> Result<Self, Failure> {
        let mut command = Command::new(python);
        command.arg(crate::root().join("benches/peers").join(script)).args(arguments);
        // Its modules are not to leave files among the sources.
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let questions = child.stdin.take().ok_or("no way to ask")?;
        let answers = BufReader::new(child.stdout.take().ok_or("no way to hear")?);
        let mut worker = Self { child, questions, answers, greeting: Value::Null };
        worker.greeting = worker.hear()?;
        Ok(worker)
    }

    /// The answer to one question.
    ///
    /// # Errors
    /// If it has ended.
    pub(crate) fn ask(&mut self, question: &Value) -> Result<Value, Failure> {
        writeln!(self.questions, "{question}")?;
        self.hear()
    }

    /// The next line that it says.
    ///
    /// # Errors
    /// If it has ended.
    pub(crate) fn hear(&mut self) -> Result<Value, Failure> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            return Err("the script ended".into());
        }
        serde_json::from_str(&line).map_err(|_| format!("the script said: {}", line.trim()).into())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
