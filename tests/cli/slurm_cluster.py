"""A Slurm cluster of one node on this machine's loopback, for the tests of --executor slurm.

slurmctld, slurmd and munged are child processes with their own folder, keys and ports; nothing of
an installed cluster is read or changed. They need root: slurmd starts jobs as their user, and
munged's key and socket have to belong to those who use them."""

import os
import pathlib
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol", "sinfo")
SEARCH = os.pathsep.join((os.environ.get("PATH", ""), "/usr/sbin", "/sbin"))

CONFIGURATION = """\
ClusterName=occlab
SlurmctldHost=localhost
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
EnforcePartLimits=ALL
KillWait=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=main Nodes=localhost Default=YES MaxTime=60 State=UP
"""


def why_not():
    """Why no cluster can be started here; "" where one can."""
    if os.geteuid() != 0:
        return "slurmd needs root"
    missing = [name for name in PROGRAMS if not shutil.which(name, path=SEARCH)]
    return f"not installed: {', '.join(missing)} (slurm-wlm, munge)" if missing else ""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Cluster:
    """Started by the constructor; stop() ends all of it, whatever happened in between."""

    def __init__(self, cpus=2):
        self.daemons = []
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="occlab-slurm-"))
        try:
            self.start(cpus)
        except BaseException:
            self.stop()
            raise

    def start(self, cpus):
        # munged refuses a key that others can read, and a socket in a folder that others cannot
        # enter; mkdtemp makes folders that only the owner can.
        self.folder.chmod(0o755)
        for name in ("munge", "state", "spool"):
            (self.folder / name).mkdir(mode=0o755)
        key = self.folder / "munge/key"
        key.touch(mode=0o600)
        key.write_bytes(secrets.token_bytes(128))
        configuration = self.folder / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(
            folder=self.folder, controller_port=free_port(), node_port=free_port(), cpus=cpus),
            encoding="utf-8")
        self.environment = {"SLURM_CONF": str(configuration), "PATH": SEARCH}
        munge = self.folder / "munge"
        self.daemon("munged", "--foreground", f"--socket={munge}/socket", f"--key-file={key}",
                    f"--log-file={munge}/log", f"--pid-file={munge}/pid",
                    f"--seed-file={munge}/seed", "--num-threads=10")
        self.wait_until("munged's socket", lambda: (munge / "socket").exists())
        self.daemon("slurmctld", "-D", "-i", "-f", configuration)
        self.daemon("slurmd", "-D", "-f", configuration, "-N", "localhost")
        self.wait_until("an idle node", lambda: self.node_state() == "idle")

    def daemon(self, *command):
        output = open(self.folder / f"{command[0]}.out", "wb")
        with output:
            self.daemons.append(subprocess.Popen(
                [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=output,
                stderr=subprocess.STDOUT, env={**os.environ, **self.environment}))

    def stop(self):
        if len(self.daemons) > 1:  # jobs outlive slurmd
            self.run("scancel", "--me", "--signal=KILL", "--full")
            self.run("scancel", "--me")
            deadline = time.monotonic() + 10
            while self.queue() and time.monotonic() < deadline:
                time.sleep(0.1)
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
        for daemon in reversed(self.daemons):
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self.daemons = []
        shutil.rmtree(self.folder, ignore_errors=True)

    def run(self, *command, timeout=30):
        return subprocess.run([str(word) for word in command], capture_output=True, text=True,
                              timeout=timeout, check=False,
                              env={**os.environ, **self.environment})

    def node_state(self):
        return self.run("sinfo", "--noheader", "--format=%T").stdout.strip()

    def queue(self):
        """Lines "ID STATE" of what has not ended."""
        return self.run("squeue", "--me", "--array", "--noheader",
                        "--format=%i %T").stdout.splitlines()

    def wait_until(self, what, condition, seconds=60):
        deadline = time.monotonic() + seconds
        while not condition():
            ended = [daemon.args[0] for daemon in self.daemons if daemon.poll() is not None]
            if ended or time.monotonic() > deadline:
                raise RuntimeError(f"the Slurm cluster has not come to {what}; "
                                   f"ended: {ended}; {self.messages()}")
            time.sleep(0.1)

    def messages(self):
        return "\n".join(f"{path.name}: {path.read_text(errors='replace')[-1500:]}"
                         for path in sorted(self.folder.glob("*.out")))
