// A controller of one's own in Java, in place of wallctl (docs/your-own-controller.md): keeps the lateral stress while it
// compresses the box in z at a constant velocity, 2000 steps long. Nothing of Shakedown but the messages is used.
//
//     lcm-gen -j --jpath build/java lcmtypes/*.lcm
//     javac -cp /usr/share/java/lcm.jar -d build/java build/java/shakedown/*.java examples/Controller.java
//     ./shakedown run scenes/quick.cfg --controller "java -cp /usr/share/java/lcm.jar:build/java Controller"
import java.io.IOException;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;
import shakedown.end_t;
import shakedown.wall_command_t;
import shakedown.wall_state_t;

public final class Controller implements LCMSubscriber {
    private static final int STEPS = 2000, INTERVAL = 8;
    private static final double VELOCITY_M_PER_S = -0.01; // of the upper wall in z
    private static final double PRESSURE_PA = 500, DAMPING_KG_PER_S = 200; // of the upper wall in x

    private final long runId;
    private volatile int exitCode = -1;

    private Controller(long runId) {
        this.runId = runId;
    }

    @Override
    public void messageReceived(LCM lcm, String channel, LCMDataInputStream bytes) {
        try {
            if (channel.equals("END")) {
                exitCode = new end_t(bytes).run_id == runId ? 0 : exitCode;
                return;
            }
            final wall_state_t state = new wall_state_t(bytes);
            if (state.run_id == runId) {
                lcm.publish("WALL_COMMAND", answer(state));
            }
        } catch (IOException broken) {
            System.err.println("controller: " + broken);
            exitCode = 1;
        }
    }

    // From the state alone: a repeated state gets a copy, and this program may be started again at any time.
    private static wall_command_t answer(wall_state_t state) {
        final int n = state.n_walls;
        final wall_command_t command = new wall_command_t();
        command.run_id = state.run_id;
        command.seq = state.seq; // of the state that this answers
        command.step = state.command_step; // from which the command holds
        command.time_s = state.time_s;
        command.n_walls = n;
        command.drive = new int[n]; // 0: a path
        command.position_m = state.position_m.clone(); // walls do not jump
        command.velocity_m_per_s = new double[n];
        command.acceleration_m_per_s2 = new double[n];
        command.force_n = new double[n];
        command.force_rate_n_per_s = new double[n];
        command.force_rate2_n_per_s2 = new double[n];
        command.mass_kg = new double[n];
        command.damping_kg_per_s = new double[n];
        final int left = state.stage < 0 ? STEPS : STEPS - (int) state.stage_step;
        command.stage = Math.max(0, state.stage);
        if (left <= 0) {
            command.finished = 1;
            command.ended = 1; // the stage by its length
            command.fraction_done = 1;
            return command;
        }
        command.n_steps = Math.min(left, INTERVAL);
        command.fraction_done = 1 - (double) left / STEPS;
        command.velocity_m_per_s[n - 1] = VELOCITY_M_PER_S;
        // A wall without mass on a dashpot: it goes where the force on it is more than the pressure asks for.
        final double area = state.position_m[n - 1] - state.position_m[n - 2]; // 2D: depth 1 m
        command.velocity_m_per_s[1] = (state.force_n[1] - PRESSURE_PA * area) / DAMPING_KG_PER_S;
        command.drive[1] = 1; // a path that answers the force, and the force it was made from
        command.force_n[1] = state.force_n[1];
        return command;
    }

    // Arguments: SCENE [--set KEY=VALUE]... --run-id N --lcm URL; scene and settings do not matter here.
    public static void main(String[] arguments) throws Exception {
        long runId = 0;
        String url = null;
        for (int k = 1; k + 1 < arguments.length; k++) {
            if (arguments[k].equals("--run-id")) {
                runId = Long.parseLong(arguments[k + 1]);
            } else if (arguments[k].equals("--lcm")) {
                url = arguments[k + 1];
            }
        }
        final LCM lcm = new LCM(url);
        final Controller controller = new Controller(runId);
        lcm.subscribe("WALL_STATE", controller);
        lcm.subscribe("END", controller);
        while (controller.exitCode < 0) {
            Thread.sleep(20);
        }
        System.exit(controller.exitCode);
    }
}
