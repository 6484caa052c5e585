"""A real Slurm on this machine, from Debian's packages slurm-wlm and munge, with one node of some cores."""

import os
import shutil
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

PROGRAMS = ("sbatch", "slurmctld", "slurmd", "munged")
CORES = 8
REQUEUE_DELAY = 10  # s that a job waits in the queue before it starts again; 120 where cred_expire is not given
CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=cred_expire={requeue_delay}
MpiDefault=none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
ReturnToService=2
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmdSpoolDir={folder}/spool
StateSaveLocation={folder}/state
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdParameters=config_overrides
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MinJobAge=36000
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=4000
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def available():
    """True where it can be started."""
    return os.geteuid() == 0 and all(shutil.which(name) for name in PROGRAMS)


@contextmanager
def running(folder):
    """In this block a Slurm with its state in ``folder`` takes jobs; SLURM_CONF leads sbatch to it."""
    host = os.uname().nodename
    for name in ("spool", "state"):
        (folder / name).mkdir()
    file = folder / "slurm.conf"
    file.write_text(CONFIGURATION.format(host=host, folder=folder, cores=CORES, requeue_delay=REQUEUE_DELAY))
    for path, mode in (("/run/munge", 0o755), ("/var/log/munge", 0o700), ("/var/lib/munge", 0o700)):
        Path(path).mkdir(exist_ok=True)
        shutil.chown(path, "munge", "munge")
        os.chmod(path, mode)
    before = os.environ.get("SLURM_CONF")
    os.environ["SLURM_CONF"] = str(file)
    processes = [
        subprocess.Popen(["runuser", "-u", "munge", "--", "munged", "--foreground"], stderr=subprocess.DEVNULL)
    ]
    try:
        waited(lambda: subprocess.run(["munge", "-n"], capture_output=True).returncode == 0)
        for words in (["slurmctld", "-D"], ["slurmd", "-D"]):
            processes.append(subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        waited(lambda: reported("sinfo", "-h", "-o", "%T").strip() == "idle")
        yield
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait(timeout=30)
        os.environ.pop("SLURM_CONF")
        if before is not None:
            os.environ["SLURM_CONF"] = before


def reported(*words):
    """What a command prints."""
    return subprocess.run(words, capture_output=True, text=True).stdout


def waited(done, seconds=60.0):
    """Wait until ``done()``; AssertionError when that takes too long."""
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end
        time.sleep(0.5)


def states():
    """{number of a job: state} of all that Slurm remembers."""
    rows = (line.split() for line in reported("squeue", "-h", "-r", "-t", "all", "-o", "%i %T").splitlines())
    return {number: state for number, state in rows}
