//! A script of `benches/peers` that keeps running and answers requests line by line, in JSON.

use crate::Failure;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A running script; it is killed when the value is dropped.
pub(crate) struct Worker {
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// Its first line, which it printed when it was ready.
    pub(crate) greeting: Value,
}

impl Worker {
    /// Starts `script` with `arguments` and waits until it is ready.
    ///
    /// # Errors
    /// If it cannot be started or ends before that; its messages are on standard error.
    pub(crate) fn start(
        python: &Path,
        script: &str,
        arguments: impl IntoIterator<Item = String>,
    ) -> Result<Self, Failure> {
        let mut command = Command::new(python);
        command.arg(crate::root().join("benches/peers").join(script)).args(arguments);
        // Its modules must not leave files among the sources.
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let questions = child.stdin.take().ok_or("the script has no standard input")?;
        let answers =
            BufReader::new(child.stdout.take().ok_or("the script has no standard output")?);
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

    /// The next line that it prints.
    ///
    /// # Errors
    /// If it has ended.
    pub(crate) fn hear(&mut self) -> Result<Value, Failure> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            return Err("the script ended".into());
        }
        serde_json::from_str(&line)
            .map_err(|_| format!("the script printed: {}", line.trim()).into())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
