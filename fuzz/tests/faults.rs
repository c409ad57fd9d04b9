//! Runs a few faults at random moments of the commands that write; `faults --count 200` runs many.
#![cfg(unix)]

use std::process::Command;

#[test]
#[ignore = "slow: six commands that are killed, and again without"]
fn what_faults_leave_is_one_whole_result_or_none_and_goes_on_to_the_same_bits() {
    let mut faults = Command::new(env!("CARGO_BIN_EXE_unrender-fuzz"));
    let output = faults.args(["faults", "--count", "6", "--seed", "1"]).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let said = format!("{}{}", text(&output.stdout), text(&output.stderr));
    println!("{said}");
    assert!(output.status.success(), "{said}");
}

#[test]
#[ignore = "slow: every command by four ways"]
fn threads_and_avx2_change_no_bit_of_any_result() {
    let output = Command::new(env!("CARGO_BIN_EXE_unrender-fuzz")).arg("bits").output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let said = format!("{}{}", text(&output.stdout), text(&output.stderr));
    println!("{said}");
    assert!(output.status.success(), "{said}");
}
