"""The script of the tutorial on a real Slurm of one node, on the loopback interface; skipped where it is not installed.

munged, slurmctld and slurmd are started by the test in a private folder, and ended by it.
"""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from small_plans import GEAR_VARIABLES, PROGRAM

from regression.data.dataset import load_dataset
from regression.formula import Formula

COMMANDS = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")
MISSING = [name for name in COMMANDS if shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin") is None]
pytestmark = [
    pytest.mark.skipif(bool(MISSING), reason=f"Slurm is not installed: {', '.join(MISSING)} (slurm-wlm, munge)"),
    pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="slurmd needs the administrator"),
]
CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=10
CryptoType=crypto/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
KillWait=2
SchedulerParameters=bf_interval=2,sched_interval=2,batch_sched_delay=0
JobRequeue=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName={host} NodeAddr=127.0.0.1 CPUs=8 RealMemory=16000 State=UNKNOWN
PartitionName=short Nodes=ALL Default=YES MaxTime=08:00:00 State=UP
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmdParameters=config_overrides
"""


def run(*command: str | Path) -> str:
    """Standard output of a command that must succeed."""
    ended = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def wait(what: Callable[[], bool], seconds: float = 600.0) -> None:
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.3)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder of commands, after munged, slurmctld and slurmd have started."""
    folder = tmp_path_factory.mktemp("slurm")
    folder.chmod(0o755)
    (folder / "state").mkdir()
    host = socket.gethostname().partition(".")[0]
    with socket.socket() as one, socket.socket() as two:
        one.bind(("127.0.0.1", 0))
        two.bind(("127.0.0.1", 0))
        ports = (one.getsockname()[1], two.getsockname()[1])
    (folder / "slurm.conf").write_text(CONFIGURATION.format(host=host, ports=ports, folder=folder))
    program = f"#!/bin/bash\nexec {sys.executable} -c '{PROGRAM}' \"$@\"\n"
    (folder / "mixed-ehl").write_text(program)
    (folder / "mixed-ehl").chmod(0o755)
    before = dict(os.environ)
    os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
    os.environ["PATH"] = f"{folder}:{os.environ['PATH']}:/usr/sbin:/sbin"
    run("mungekey", "--create", "--keyfile", folder / "munge.key")
    socket_of = f"--socket={folder}/munge.socket"
    own = [f"--key-file={folder}/munge.key", f"--pid-file={folder}/munge.pid", f"--seed-file={folder}/munge.seed"]
    started: list[subprocess.Popen[bytes]] = []
    try:
        for command in (
            ["munged", "--foreground", "--force", socket_of, *own, f"--log-file={folder}/munge.log"],
            ["slurmctld", "-D"],
            ["slurmd", "-D", "-N", host],
        ):
            quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            started.append(subprocess.Popen(command, **quiet))  # type: ignore[call-overload]
            time.sleep(1.0)
        answers = lambda: subprocess.run(["sinfo", "-h", "-t", "idle", "-o", "%D"], capture_output=True, text=True)  # noqa: E731
        wait(lambda: answers().stdout.strip() == "1", 60.0)
        yield folder
        subprocess.run(["scancel", "--user=root", "--full", "--signal=KILL"], capture_output=True, timeout=30)
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait(20)
        os.environ.clear()
        os.environ.update(before)


def queue(state: str = "all") -> list[str]:
    return run("squeue", "-h", "-t", state, "-r", "-o", "%i").split()


def ended() -> bool:
    return not queue("pending,running,completing")


def test_the_script_of_the_tutorial(
    cluster: Path, mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Array, merge and fit; a task that is cancelled, one that is requeued; the same bits as a local run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan.toml").write_text('name = "array"\n[sampling]\nsize = 32\n' + GEAR_VARIABLES)
    options = ("--with", "arana_2019", "--set", "sampling.seed=5")
    chain = ("--merge", "all.h5", "--fit", "array.json", "--sbatch", "partition=short", "--jobs", "1")
    script = mixed_ehl("sweep", "plan.toml", "-o", "run", "--slurm", "2", *options, *chain).out
    # the first tasks wait to be found
    slow = tmp_path / "slow.sh"
    slow.write_text(script.replace("exec mixed-ehl sweep", "sleep 5; exec mixed-ehl sweep"))
    number = run("bash", slow).split()[1].rstrip(":")
    wait(lambda: len(queue("running")) == 2)
    run("scancel", f"{number}_1")
    run("scontrol", "requeue", f"{number}_2")
    wait(ended)
    # one task was cancelled: nothing is merged, the other has its results
    assert not (tmp_path / "all.h5").exists()
    assert [path.name for path in (tmp_path / "run").glob("*.jsonl")] == ["shard-0002-of-0002.jsonl"]
    (tmp_path / "submit.sh").write_text(script)
    run("bash", "submit.sh")
    wait(ended)
    assert mixed_ehl("sweep", "plan.toml", "-o", "local", "--jobs", "1", *options).code == 0
    local = load_dataset(tmp_path / "local").data_hash
    assert load_dataset(tmp_path / "all.h5").data_hash == local
    assert Formula.load(tmp_path / "array.json").data.hash == local


def test_a_task_out_of_time_goes_on_from_what_it_has(
    cluster: Path, mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Solved contacts whose task is killed in between: resumed, the data are those of one local run."""
    monkeypatch.chdir(tmp_path)
    content = 'name = "killed"\n[sampling]\nsize = 64\n[model]\naccuracy = "fast"\n' + GEAR_VARIABLES
    (tmp_path / "plan.toml").write_text(content.replace("roughness_rms", "# roughness_rms"))
    script = mixed_ehl("sweep", "plan.toml", "-o", "run", "--slurm", "1", "--merge", "all.h5", "--jobs", "1").out
    (tmp_path / "submit.sh").write_text(script)
    number = run("bash", "submit.sh").split()[1].rstrip(":")
    shard = tmp_path / "run" / "shard-0001-of-0001.jsonl"
    wait(lambda: shard.exists() and shard.read_bytes().count(b"\n") > 2)
    subprocess.run(["scancel", "--signal=KILL", "--full", f"{number}_1"], check=True)
    wait(ended)
    run("bash", "submit.sh")
    wait(ended)
    assert mixed_ehl("sweep", "plan.toml", "-o", "local", "--jobs", "1").code == 0
    assert load_dataset(tmp_path / "all.h5").data_hash == load_dataset(tmp_path / "local").data_hash
