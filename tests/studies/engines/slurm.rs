//! A cluster of one node on this machine: Slurm with its own configuration in a temporary folder.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for anything of the cluster, on a machine that is busy with other work too.
const LONGEST: Duration = Duration::from_secs(1200);

pub struct Cluster {
    folder: PathBuf,
    munged: Child,
    controller: Child,
    node: Child,
}

/// The first of the usual places that has a program.
fn program(name: &str) -> Option<PathBuf> {
    ["/usr/sbin", "/usr/bin", "/sbin"].iter().map(|f| Path::new(f).join(name)).find(|p| p.is_file())
}

fn host() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").expect("Linux");
    name.trim().split('.').next().unwrap_or_default().to_string()
}

fn free_ports() -> [u16; 2] {
    let taken = [0, 1].map(|_| TcpListener::bind("127.0.0.1:0").expect("a free port"));
    taken.map(|listener| listener.local_addr().expect("an address").port())
}

/// Calls `found` until it returns something.
pub fn wait_for<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(value) = found() {
            return value;
        }
        assert!(begin.elapsed() < LONGEST, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

impl Cluster {
    /// Starts it; `None`, with a message, where its programs are not installed or this user may not start them.
    pub fn start(folder: &Path) -> Option<Self> {
        let names = ["munged", "slurmctld", "slurmd", "sbatch"];
        if let Some(missing) = names.into_iter().find(|name| program(name).is_none()) {
            println!("skipped: {missing} is missing; apt install slurm-wlm munge");
            return None;
        }
        let is_root = Command::new("id").arg("-u").output().is_ok_and(|o| o.stdout == b"0\n");
        if !is_root {
            println!("skipped: only root can start a node of Slurm");
            return None;
        }
        for name in ["state", "spool"] {
            std::fs::create_dir_all(folder.join(name)).expect("room");
        }
        let key: Vec<u8> = (0..128u8).map(|k| k.wrapping_mul(37) ^ std::process::id() as u8).collect();
        std::fs::write(folder.join("key"), key).expect("room");
        {
            use std::os::unix::fs::PermissionsExt;
            let only_owner = std::fs::Permissions::from_mode(0o600);
            std::fs::set_permissions(folder.join("key"), only_owner).expect("own file");
            std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755)).expect("own folder");
        }
        std::fs::write(folder.join("slurm.conf"), configuration(folder)).expect("room");
        let place = |name: &str| format!("{}/{name}", folder.display());
        let munged = daemon(folder, "munged")
            .args(["--foreground", "--force", "--key-file", &place("key"), "--socket", &place("munge.sock")])
            .args([
                "--pid-file",
                &place("munged.pid"),
                "--log-file",
                &place("munged.log"),
                "--seed-file",
                &place("seed"),
            ])
            .spawn()
            .expect("munged starts");
        wait_for("munged", || folder.join("munge.sock").exists().then_some(()));
        let controller =
            daemon(folder, "slurmctld").args(["-D", "-f", &place("slurm.conf")]).spawn().expect("it starts");
        let node = Self::start_node(folder);
        let cluster = Self { folder: folder.into(), munged, controller, node };
        wait_for("an idle node", || cluster.said("sinfo", &["-h", "-o", "%T"]).starts_with("idle").then_some(()));
        Some(cluster)
    }

    fn start_node(folder: &Path) -> Child {
        let conf = format!("{}/slurm.conf", folder.display());
        daemon(folder, "slurmd").args(["-D", "-f", &conf, "-N", &host()]).spawn().expect("it starts")
    }

    /// The node dies with all that runs on it, is found to be gone, and comes back.
    pub fn kill_node(&mut self) {
        self.node.kill().expect("it runs");
        self.node.wait().expect("it ends");
        kill_tasks(&self.folder);
        wait_for("a node that is down", || self.said("sinfo", &["-h", "-o", "%T"]).starts_with("down").then_some(()));
        self.node = Self::start_node(&self.folder);
    }

    pub fn configuration(&self) -> PathBuf {
        self.folder.join("slurm.conf")
    }

    /// Standard output of a command of the cluster.
    pub fn said(&self, name: &str, arguments: &[&str]) -> String {
        let mut command = Command::new(name);
        let output = command.args(arguments).env("SLURM_CONF", self.configuration()).output().expect("it starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Waits until no job is left.
    pub fn wait(&self) {
        wait_for("the end of all jobs", || self.said("squeue", &["-h"]).trim().is_empty().then_some(()));
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        self.said("scancel", &["-u", "root"]);
        kill_tasks(&self.folder);
        for daemon in [&mut self.node, &mut self.controller, &mut self.munged] {
            daemon.kill().ok();
            daemon.wait().ok();
        }
    }
}

fn daemon(folder: &Path, name: &str) -> Command {
    let log = std::fs::File::create(folder.join(format!("{name}.out"))).expect("room");
    let mut command = Command::new(program(name).expect("it was found"));
    command.env("SLURM_CONF", folder.join("slurm.conf")).stdin(Stdio::null());
    command.stdout(log.try_clone().expect("a file")).stderr(log);
    command
}

fn configuration(folder: &Path) -> String {
    let (host, [controller, node], d) = (host(), free_ports(), folder.display());
    format!(
        "ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={d}/munge.sock,cred_expire=5
CredType=cred/munge
StateSaveLocation={d}/state
SlurmdSpoolDir={d}/spool
SlurmctldPidFile={d}/slurmctld.pid
SlurmdPidFile={d}/slurmd.pid
SlurmctldLogFile={d}/slurmctld.log
SlurmdLogFile={d}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SchedulerParameters=sched_min_interval=1,batch_sched_delay=1
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
SlurmdTimeout=4
KillWait=2
JobRequeue=1
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
JobAcctGatherType=jobacct_gather/none
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=2000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"
    )
}

/// Kills the scripts of jobs of this folder, the processes that watch them, and what they have started.
pub fn kill_tasks(folder: &Path) {
    let spool = format!("{}/spool/", folder.display());
    let processes = || std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = || processes().filter_map(|p| p.file_name().to_str()?.parse::<u32>().ok());
    let parent = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        stat.rsplit(')').next()?.split_whitespace().nth(1)?.parse::<u32>().ok()
    };
    let command = |pid: u32| std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    let is_script = |pid: &u32| String::from_utf8_lossy(&command(*pid)).contains(&spool);
    let scripts: Vec<u32> = numbers().filter(is_script).collect();
    let mut doomed: Vec<u32> = scripts.iter().filter_map(|pid| parent(*pid)).filter(|pid| *pid > 1).collect();
    doomed.retain(|pid| String::from_utf8_lossy(&command(*pid)).starts_with("slurmstepd"));
    doomed.extend(scripts);
    let mut next = 0;
    while let Some(&pid) = doomed.get(next) {
        let children: Vec<u32> = numbers().filter(|child| parent(*child) == Some(pid)).collect();
        doomed.extend(children.into_iter().filter(|child| !doomed.contains(child)).collect::<Vec<_>>());
        next += 1;
    }
    for pid in doomed {
        Command::new("kill").args(["-9", &pid.to_string()]).output().ok();
    }
}
